//! Links to a board over byte streams, by name, and a host driven over one.
//!
//! | name                                 | what                                         |
//! |--------------------------------------|----------------------------------------------|
//! | `usb:`, `usb:SERIAL`                 | the control pipes of a board's USB port      |
//! | `serial:///dev/ttyACM0`, `serial:`   | a serial port; without a path, the board's by its USB identity |
//! | `tcp://HOST:PORT`                    | a socket                                     |
//! | `pty:`, `pty:///dev/pts/3`           | a pseudo-terminal, a new one or an existing one |
//!
//! The Feather shows two ports on USB: a serial port, which is its transparent port,
//! and pipes of its own, which are its control link. `serial:` finds a board by its
//! serial port and takes whichever of the two carries the link; for the servo bus
//! ([`servo_bus`](crate::servo_bus)) the same name means the transparent port.
//!
//! | module         | what                                                       |
//! |----------------|------------------------------------------------------------|
//! | [`uri`]        | names, read and written                                    |
//! | [`usb_discovery`]   | a board's serial port by its USB identity                  |
//! | [`usb`]        | a board's control pipes                                    |
//! | `open`         | a link that is a byte stream, opened                       |
//! | `wall_clock`   | a host on a byte stream, which may break and come back     |
//! | `disconnect_guard`      | a connection that does not end without one                 |

mod clock;
mod disconnect_guard;
mod open;
#[cfg(unix)]
mod terminal;
pub mod uri;
pub mod usb;
pub mod usb_discovery;
mod wall_clock;

pub use uri::LinkUriError;

use std::path::PathBuf;
use std::time::Duration;

use crate::endpoint::Endpoint;
use crate::{Host, Tap};

/// Sent to a second host of a board that is served on a socket, in plain words for
/// whatever program it is. The zero ends it as it ends a frame.
pub const IN_USE: &[u8] = b"armbridge: another host has this link\0";

/// Name of a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkUri {
    /// The board with this serial number, or the only one.
    Usb(Option<String>),
    /// This port, or the one of the only board.
    Serial(Option<PathBuf>),
    /// A socket.
    Tcp(Endpoint),
    /// This terminal, or a new one.
    Pty(Option<PathBuf>),
}

/// For how long a broken link is tried again, unless said otherwise: as long as it
/// takes to plug a cable in again, and a board to boot.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a link is opened with.
pub struct LinkOptions {
    /// For how long a broken link is tried again.
    pub patience: Duration,
    /// Listeners.
    pub taps: Vec<Box<dyn Tap>>,
    /// Nothing is written to standard error when the link breaks or comes back: for
    /// a program that draws on the terminal and listens to [`Tap::disconnected`].
    pub is_quiet: bool,
}

impl Default for LinkOptions {
    /// 10 s of patience, no listeners.
    fn default() -> Self {
        Self {
            patience: PATIENCE,
            taps: Vec::new(),
            is_quiet: false,
        }
    }
}

/// Why a host could not be driven to its end.
#[derive(Debug, thiserror::Error)]
pub enum LinkError<H> {
    /// The link cannot be opened, or broke for good: one sentence that says what to do.
    #[error("{0}")]
    Link(String),
    /// The host gave up.
    #[error(transparent)]
    Host(H),
}

/// Drives `host` over the link until it is done. Reopens a link that breaks, and
/// tells the host by [`Host::disconnected`]. The host comes back whatever happened.
///
/// The host is asked to speak every 20 ms at the latest, also while the link is broken;
/// what it says then is lost. If it gives up or panics, the board is told goodbye, which
/// disarms it; where even that is not possible, the board finds its host silent and acts
/// by itself.
pub fn drive<H: Host>(
    uri: &LinkUri,
    options: LinkOptions,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    wall_clock::run(uri, options, host)
}
