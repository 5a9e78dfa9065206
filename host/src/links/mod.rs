//! Links to a board, by name, and a host driven over one.
//!
//! | name                                 | what                                         |
//! |--------------------------------------|----------------------------------------------|
//! | `usb:`, `usb:SERIAL`                 | the control pipes of a board's USB port      |
//! | `serial:///dev/ttyACM0`, `serial:`   | a serial port; without a path, the board's by its USB identity |
//! | `tcp://HOST:PORT`                    | a socket, such as `emulate --link-listen`    |
//! | `pty:`, `pty:///dev/pts/3`           | a pseudo-terminal, a new one or somebody's   |
//! | `sim:`                               | the board's code and the bench, in this process |
//! | `emulate:`, `emulate:IMAGE`          | the firmware image under QEMU, with the bench |
//!
//! The Feather shows two ports on USB: a serial port, which is its transparent port,
//! and pipes of its own, which are its control link. `serial:` finds a board by its
//! serial port and takes whichever of the two carries the link; for the servo bus
//! (`scan`, `servo`) the same name means the transparent port.
//!
//! | module         | what                                                       |
//! |----------------|------------------------------------------------------------|
//! | [`uri`]        | names, read and written                                    |
//! | [`identity`]   | a board's serial port by its USB identity                  |
//! | [`usb`]        | a board's control pipes                                    |
//! | `open`         | a link that is a byte stream, opened                       |
//! | `wall_clock`   | a host on a byte stream, which may break and come back     |
//! | `goodbye`      | a connection that does not end without one                 |
//! | `world`        | a host on the bench, in virtual time                       |

mod clock;
mod goodbye;
pub mod identity;
mod open;
#[cfg(unix)]
mod terminal;
pub mod uri;
pub mod usb;
mod wall_clock;
mod world;

pub use uri::LinkUriError;
pub use world::run as drive_board;

use std::path::PathBuf;
use std::time::Duration;

use armbridge_shared::bridge::Channels;

use crate::bench::Bench;
use crate::bench::board::VirtualBoard;
use crate::bench::cosim::{Client, Host};
use crate::endpoint::Endpoint;
use crate::log::event::Direction;

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
    /// The bench.
    Sim,
    /// The emulator, with this image or the one that was built last.
    Emulate(Option<PathBuf>),
}

/// Whoever listens to the raw bytes of a link. Called on the thread that serves the
/// link: must not wait.
pub trait Tap: Send {
    /// These bytes were written or read at this time (ns since 1970, or of virtual time).
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]);

    /// The connection broke at this time.
    fn parted(&mut self, host_ns: u64);
}

/// How fast virtual time goes on `sim:` and `emulate:`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As fast as it can be computed.
    Free,
    /// Held back to the wall clock.
    WallClock,
}

/// For how long a broken link is tried again, unless said otherwise: as long as it
/// takes to plug a cable in again, and a board to boot.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a link is opened with.
pub struct Options {
    /// Servos and arm, for `sim:` and `emulate:`.
    pub bench: Bench,
    /// For `sim:` and `emulate:`.
    pub pace: Pace,
    /// For how long a broken link is tried again.
    pub patience: Duration,
    /// Who listens.
    pub taps: Vec<Box<dyn Tap>>,
    /// Nothing is written to standard error when the link breaks or comes back: for
    /// whoever has the terminal and hears [`Tap::parted`].
    pub is_quiet: bool,
    /// Who uses the board's transparent port, for `sim:` and `emulate:`.
    pub client: Option<Box<dyn Client>>,
}

impl Options {
    /// As fast as it goes on this bench, 10 s of patience, nobody who listens.
    pub fn new(bench: Bench) -> Self {
        Self {
            bench,
            pace: Pace::Free,
            patience: PATIENCE,
            taps: Vec::new(),
            is_quiet: false,
            client: None,
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
/// tells the host by [`Host::parted`]. The host comes back whatever happened.
///
/// In wall-clock time the host is asked to speak every 20 ms at the latest, also
/// while the link is broken; what it says then is lost. If it gives up or panics, the
/// board is told goodbye, which disarms it; where even that is not possible, the board
/// finds its host silent and acts by itself.
pub fn drive<H: Host>(
    uri: &LinkUri,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    match uri {
        LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Tcp(_) | LinkUri::Pty(_) => {
            wall_clock::run(uri, options, host)
        }
        LinkUri::Sim => {
            let mut channels = Channels::new();
            match VirtualBoard::new(channels.split()) {
                Ok(board) => world::run(board, options, host),
                Err(refusal) => {
                    let why = crate::refusal::in_words(refusal);
                    let why = format!("the default set-up has no controller: {why}");
                    (host, Err(LinkError::Link(why)))
                }
            }
        }
        LinkUri::Emulate(image) => emulate(image.as_deref(), options, host),
    }
}

#[cfg(unix)]
fn emulate<H: Host>(
    image: Option<&std::path::Path>,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    match world::emulated(image) {
        Ok(board) => world::run(board, options, host),
        Err(error) => (host, Err(LinkError::Link(error.to_string()))),
    }
}

#[cfg(not(unix))]
fn emulate<H: Host>(
    _: Option<&std::path::Path>,
    _: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    let why = "`emulate:` needs Linux or macOS; `sim:` runs everywhere";
    (host, Err(LinkError::Link(why.into())))
}
