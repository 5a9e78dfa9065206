//! Boards by URI, real and simulated, and a host driven on one.
//!
//! | name                        | board                                                 |
//! |-----------------------------|-------------------------------------------------------|
//! | `usb:`, `serial:`, `tcp:`, `pty:` | a board at a byte stream, see [`transport`]     |
//! | `sim:`                      | the board's code and the bench, in this process       |
//! | `emulate:`, `emulate:IMAGE` | the current tree's or another firmware image under QEMU, with the bench |
//! | `emulate:?icount`           | each instruction takes a fixed virtual time           |
//! | `emulate:?bus=tcp://HOST:PORT&slow=50` | the image in slowed wall-clock time, on an external servo bus |
//!
//! [`drive`] runs a host on one; a [`LinkThread`] does so on a thread of its own, and a
//! [`BoardClient`] makes calls of that.

mod board_client;
#[cfg(unix)]
mod emulated;
mod link_thread;
mod uri;
mod virtual_board;

pub use board_client::{ActiveMotion, BoardClient, ClientError, CommandSender, SetpointSender};
pub use link_thread::{LinkThread, LinkThreadError};
pub use uri::{BoardUri, BoardUriError, CHOICES, EmulatorUri, ExternalBus};
pub use virtual_board::run as drive_board;

use std::sync::mpsc::Receiver;

use armbridge_board::bridge::Channels;
use armbridge_client::transport::stop_socket::StopRelay;
use armbridge_client::transport::{self, LinkOptions};
use armbridge_client::{Host, LinkError, refusal_text, stdio};
use armbridge_link::message::Refusal;

use crate::Bench;
use crate::board::VirtualBoard;
use crate::cosim::{Interaction, PortClient};

/// Pace of virtual time on `sim:` and `emulate:`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As fast as it can be computed.
    Free,
    /// Not faster than the wall clock.
    WallClock,
}

/// Options of a board. All but `link` are for `sim:` and `emulate:`.
pub struct Options {
    /// Servos and arm.
    pub bench: Bench,
    /// Pace of virtual time.
    pub pace: Pace,
    /// Program on the board's transparent port.
    pub client: Option<Box<dyn PortClient>>,
    /// Interactions with the arm.
    pub interactions: Option<Receiver<Interaction>>,
    /// Takes the name of an emulated board's image, and each line that the board logs.
    pub board_log: fn(&str),
    /// Other programs may stop the board from a second terminal, as they may a real one.
    pub is_stoppable: bool,
    /// Options of a real link, and the taps.
    pub link: LinkOptions,
}

impl Options {
    /// Free pace on this bench, without interactions and taps.
    pub fn new(bench: Bench) -> Self {
        Self {
            bench,
            pace: Pace::Free,
            client: None,
            interactions: None,
            board_log: |_| {},
            is_stoppable: false,
            link: LinkOptions::default(),
        }
    }
}

/// The board's default set-up has no controller.
#[derive(Debug, thiserror::Error)]
#[error("the default set-up has no controller: {}", refusal_text::in_words(*.0))]
struct NoController(Refusal);

/// Drives `host` on the board until it is done, over a real link as
/// [`transport::drive`] does. The host is returned in any case.
pub fn drive<H: Host>(
    uri: &BoardUri,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    match uri {
        BoardUri::Link(uri) => transport::drive(uri, options.link, host),
        BoardUri::Sim => {
            let mut channels = Channels::new();
            match VirtualBoard::new(channels.split()) {
                Ok(board) => relayed(uri, options, host, |options, host| {
                    virtual_board::run(board, options, host)
                }),
                Err(refusal) => (host, Err(LinkError::Link(NoController(refusal).into()))),
            }
        }
        #[cfg(unix)]
        BoardUri::Emulate(emulator) => relayed(uri, options, host, |options, host| {
            emulated::run(emulator, options, host)
        }),
        #[cfg(not(unix))]
        BoardUri::Emulate(_) => {
            let why = "`emulate:` needs Linux or macOS; `sim:` runs everywhere";
            (host, Err(LinkError::Link(why.into())))
        }
    }
}

/// Runs a host on a simulated board, with a socket for stops by other programs if they may.
fn relayed<H: Host>(
    uri: &BoardUri,
    options: Options,
    host: H,
    run: impl FnOnce(Options, StopRelay<H>) -> (StopRelay<H>, Result<(), LinkError<H::Error>>),
) -> (H, Result<(), LinkError<H::Error>>) {
    let mut relay = StopRelay::new(host);
    if options.is_stoppable
        && let Some(Err(error)) = uri.key().map(|key| relay.listen(&key))
        && !options.link.is_quiet
    {
        stdio::note(format_args!(
            "armbridge: `armbridge stop` from another terminal cannot reach {uri}: {error}"
        ));
    }
    let (relay, result) = run(options, relay);
    (relay.host, result)
}
