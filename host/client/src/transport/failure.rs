//! Errors of a link over a byte stream.

use std::io;
use std::time::Duration;

use armbridge_link::server::Program;

use super::LinkUri;
use super::usb::UsbError;
use super::usb_discovery::FindError;
use crate::endpoint::OpenError;
use crate::servo_bus::serial_device::DeviceError;

/// Reason for which a link does not open, or is lost.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// The control pipes do not open.
    #[error(transparent)]
    Usb(#[from] UsbError),
    /// There is no board, or more than one.
    #[error(transparent)]
    Find(#[from] FindError),
    /// The socket does not connect.
    #[error(transparent)]
    Connect(#[from] OpenError),
    /// The serial device does not open.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The socket cannot be configured.
    #[error(transparent)]
    Socket(#[from] io::Error),
    /// No pseudo-terminal is available.
    #[error("no pseudo-terminal is available: {0}; use tcp:// instead")]
    NoTerminal(#[source] io::Error),
    /// This system has no pseudo-terminals.
    #[error("there are no pseudo-terminals on this system: use tcp://HOST:PORT")]
    NoTerminals,
    /// The pseudo-terminal fails.
    #[error("{name}: {source}")]
    Terminal {
        /// Its path.
        name: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The other program has closed the pseudo-terminal.
    #[error("no program has {0} open")]
    NotOpen(String),
    /// Ctrl-C before the pseudo-terminal was opened.
    #[error("ctrl-c was pressed before a program opened {0}")]
    Interrupted(String),
    /// Another program commands a served link.
    #[error(
        "{0} commands this board: end that program first, or look on with `armbridge watch \
         --observe`"
    )]
    Commanded(Program),
    /// The link has one program at a time.
    #[error(
        "{0} cannot be observed, as its only program commands: observing needs a board that \
         `armbridge serve board --listen tcp://HOST:PORT` serves"
    )]
    NotObservable(LinkUri),
    /// The stream broke.
    #[error("{}", cause(.0))]
    Broken(#[source] io::Error),
    /// The link broke, and could not be opened again.
    #[error("{uri} broke ({cause}) and did not come back in {} s: {last}", patience.as_secs_f64())]
    Lost {
        /// The link.
        uri: LinkUri,
        /// Error that broke it.
        cause: String,
        /// Time for which it was retried.
        patience: Duration,
        /// Error of the last attempt.
        #[source]
        last: Box<Self>,
    },
}

fn cause(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "the other side closed it".to_owned(),
        _ => error.to_string(),
    }
}
