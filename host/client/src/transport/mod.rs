//! Links to a board over byte streams, by URI, and a host driven over one.
//!
//! | name                                 | link                                         |
//! |--------------------------------------|----------------------------------------------|
//! | `usb:`, `usb:SERIAL`                 | the control pipes of a board's USB port      |
//! | `serial:///dev/ttyACM0`, `serial:`   | a serial port; without a path, the board's by its USB identity |
//! | `tcp://HOST:PORT`                    | a socket                                     |
//! | `pty:`, `pty:///dev/pts/3`           | a pseudo-terminal, a new one or an existing one |
//!
//! The Feather shows two ports on USB: a serial port, which is its transparent port,
//! and pipes of its own, which are its control link. `serial:` finds a board by its
//! serial port and uses the one of the two that carries the link; for the servo bus
//! ([`servo_bus`](crate::servo_bus)) the same name means the transparent port.
//!
//! | module         | contents                                                   |
//! |----------------|------------------------------------------------------------|
//! | [`uri`]        | URIs, parsed and printed                                   |
//! | [`usb_discovery`] | a board's serial port by its USB identity               |
//! | [`usb`]        | a board's control pipes                                    |
//! | `open`         | opens a link that is a byte stream                         |
//! | `failure`      | reasons for which a link does not open, or is lost         |
//! | [`stop_socket`] | motors off on a board that another process has           |
//! | `wall_clock`   | a host on a byte stream, which is reopened when it breaks  |
//! | `disconnect_guard` | sends a goodbye if the host does not                   |
//! | `link_filter`  | takes messages of a link's server out of the stream         |
//! | `role`         | who commands a served link, and whether this program may   |
//! | `program`      | the name under which this program joins a served link      |
//! | [`touch`](touch::touch) | a hand on the simulated arm behind a served link  |

mod clock;
pub mod device_names;
mod disconnect_guard;
mod failure;
mod link_filter;
mod open;
mod program;
mod role;
pub mod stop_socket;
#[cfg(unix)]
mod terminal;
pub mod touch;
pub mod uri;
pub mod usb;
pub mod usb_discovery;
mod wall_clock;

pub use failure::TransportError;
pub use role::Intent;
pub use uri::LinkUriError;

use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::time::Duration;

use armbridge_link::server::Touch;

use crate::endpoint::Endpoint;
use crate::{Host, Tap};

/// URI of a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkUri {
    /// The board with this serial number, or the only one.
    Usb(Option<String>),
    /// This serial port, or the one of the only board.
    Serial(Option<PathBuf>),
    /// A socket.
    Tcp(Endpoint),
    /// This pseudo-terminal, or a new one.
    Pty(Option<PathBuf>),
}

/// Default time for which a broken link is retried: long enough
/// to plug a cable in again, and for a board to boot.
const PATIENCE: Duration = Duration::from_secs(10);

/// Options of a link.
pub struct LinkOptions {
    /// Time for which a broken link is retried.
    pub patience: Duration,
    /// Listeners to its bytes.
    pub taps: Vec<Box<dyn Tap>>,
    /// Requested role on a link that other programs may share.
    pub intent: Intent,
    /// Hands on the simulated arm behind a served link; without effect on others.
    pub touches: Option<Receiver<Touch>>,
    /// Nothing is written to standard error when the link breaks or comes back: for
    /// a program that draws on the terminal and listens to [`Tap::disconnected`].
    pub is_quiet: bool,
}

impl Default for LinkOptions {
    /// 10 s of patience, no listeners, to command.
    fn default() -> Self {
        Self {
            patience: PATIENCE,
            taps: Vec::new(),
            intent: Intent::default(),
            touches: None,
            is_quiet: false,
        }
    }
}

/// Reason for which a host did not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum LinkError<H> {
    /// The link cannot be opened, or is lost: a [`TransportError`], or an error of a
    /// simulated board. One sentence with the remedy.
    #[error(transparent)]
    Link(Box<dyn std::error::Error + Send + Sync>),
    /// Error of the host.
    #[error(transparent)]
    Host(H),
}

/// Drives `host` over the link until it is done. Reopens a link that breaks, after
/// [`Host::disconnected`]. The host is returned in any case.
///
/// The host is asked for bytes every 20 ms at the latest, also while the link is broken;
/// these bytes are dropped. If it returns an error or panics, a goodbye is sent to the board, which
/// disarms it; if that is not possible, the board detects the silence of its host.
pub fn drive<H: Host>(
    uri: &LinkUri,
    options: LinkOptions,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    wall_clock::run(uri, options, host)
}
