//! Port of the bus by its name: a serial device, a pseudo-terminal or a socket, named like
//! a link ([`LinkUri`]).

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use serial2::SerialPort;

use super::line::{Line, SerialLine, TcpLine};
use crate::endpoint::{Endpoint, OpenError};
use crate::transport::usb_discovery::FindError;
use crate::transport::{LinkUri, LinkUriError, usb_discovery};

/// Port of a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Port {
    /// A socket.
    Tcp(Endpoint),
    /// A serial device, or an existing pseudo-terminal.
    Serial(PathBuf),
    /// The transparent port of the only board that is plugged in.
    Board,
}

/// Error in a port's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// An invalid link.
    #[error(transparent)]
    Link(LinkUriError),
    /// Not a link, or one without a bus.
    #[error(
        "`{0}` carries no servo bus: expected tcp://HOST:PORT, serial: for the board's transparent \
         port, or a serial device such as /dev/ttyUSB0"
    )]
    NoBus(String),
}

impl FromStr for Port {
    type Err = PortError;

    fn from_str(name: &str) -> Result<Self, PortError> {
        match name.parse() {
            Ok(LinkUri::Tcp(endpoint)) => Ok(Self::Tcp(endpoint)),
            Ok(LinkUri::Serial(Some(path)) | LinkUri::Pty(Some(path))) => Ok(Self::Serial(path)),
            Ok(LinkUri::Serial(None)) => Ok(Self::Board),
            Ok(LinkUri::Usb(_) | LinkUri::Pty(None)) | Err(LinkUriError::Scheme(_)) => {
                Err(PortError::NoBus(name.into()))
            }
            Err(error) => Err(PortError::Link(error)),
        }
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(endpoint) => endpoint.fmt(f),
            Self::Serial(path) => path.display().fmt(f),
            Self::Board => write!(f, "serial:"),
        }
    }
}

/// Reason for which a port does not open.
#[derive(Debug, thiserror::Error)]
pub enum PortOpenError {
    /// The socket does not connect.
    #[error(transparent)]
    Tcp(#[from] OpenError),
    /// The device does not open.
    #[error("cannot open {}: {error}; {}", path.display(), advice(error))]
    Serial {
        /// Its path.
        path: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// Another program uses it.
    #[error("{} is in use by another program; end that one first", .0.display())]
    Busy(PathBuf),
    /// There is no board, or more than one.
    #[error(transparent)]
    Find(#[from] FindError),
    /// It does not support the rate.
    #[error("{} does not run at {baud} baud: {error}", path.display())]
    Baud {
        /// Its path.
        path: PathBuf,
        /// Requested rate.
        baud: u32,
        /// Error of the system.
        error: io::Error,
    },
}

fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "is it plugged in? See /dev/serial/by-id",
        io::ErrorKind::PermissionDenied => {
            "you may have to be in its group, often `dialout`: see `ls -l`"
        }
        _ => "is it a serial device?",
    }
}

impl Port {
    /// Opens it, a serial device at `baud` and exclusively.
    ///
    /// # Errors
    /// If it does not open.
    pub fn open(&self, baud: u32) -> Result<Box<dyn Line>, PortOpenError> {
        match self {
            Self::Tcp(endpoint) => Ok(Box::new(TcpLine::new(endpoint.connect()?))),
            Self::Serial(path) => Ok(Box::new(open_device(path, baud)?)),
            Self::Board => Ok(Box::new(open_device(
                &usb_discovery::find()?.terminal,
                baud,
            )?)),
        }
    }

    /// The adapter's latency timer, if it is known.
    pub fn latency_timer(&self) -> Option<LatencyTimer> {
        match self {
            // A board forwards its bytes at once.
            Self::Tcp(_) | Self::Board => None,
            Self::Serial(path) => LatencyTimer::of(path, Path::new(usb_discovery::TERMINALS)),
        }
    }
}

/// Opens a serial device exclusively.
///
/// # Errors
/// If it does not open, is in use, or does not support this rate.
pub fn open_device(path: &Path, baud: u32) -> Result<SerialLine, PortOpenError> {
    let failed = |error: io::Error| match error.kind() {
        io::ErrorKind::ResourceBusy | io::ErrorKind::WouldBlock => PortOpenError::Busy(path.into()),
        _ => PortOpenError::Serial {
            path: path.into(),
            error,
        },
    };
    let device = SerialPort::open(path, serial2::KeepSettings).map_err(failed)?;
    take(&device).map_err(failed)?;
    let latency = LatencyTimer::of(path, Path::new(usb_discovery::TERMINALS))
        .map_or(Duration::ZERO, |timer| timer.value);
    let mut line = SerialLine::new(device, baud, latency);
    match line.set_baud(baud) {
        Ok(_) => Ok(line),
        Err(error) => Err(PortOpenError::Baud {
            path: path.into(),
            baud,
            error,
        }),
    }
}

/// Locks the device: two hosts on one link disturb each other.
#[cfg(unix)]
fn take(device: &SerialPort) -> io::Result<()> {
    use rustix::fs::FlockOperation;

    // The lock is for programs that check it, the ioctl for all but the superuser's.
    rustix::fs::flock(device, FlockOperation::NonBlockingLockExclusive)?;
    Ok(rustix::termios::ioctl_tiocexcl(device)?)
}

/// Other systems let a serial device be opened once.
#[cfg(not(unix))]
fn take(_: &SerialPort) -> io::Result<()> {
    Ok(())
}

/// Time for which an FTDI adapter buffers bytes before it forwards them. Linux
/// sets it to 16 ms, which delays every reply.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LatencyTimer {
    /// File in which it can be changed.
    pub file: PathBuf,
    /// The time.
    pub value: Duration,
}

impl LatencyTimer {
    /// Timer of the device `path`, in the system's directory of terminals.
    fn of(path: &Path, terminals: &Path) -> Option<Self> {
        let device = path.canonicalize().ok()?;
        let file = terminals
            .join(device.file_name()?)
            .join("device/latency_timer");
        let text = std::fs::read_to_string(&file).ok()?;
        let value = Duration::from_millis(text.trim().parse().ok()?);
        Some(Self { file, value })
    }

    /// Remedy, if one is needed.
    pub fn hint(&self) -> Option<String> {
        let ms = self.value.as_millis();
        let file = self.file.display();
        (ms > 1).then(|| {
            format!(
                "the adapter holds every answer back for {ms} ms; \
                 `echo 1 | sudo tee {file}` makes that 1 ms"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_mistakes() {
        let serial = Port::Serial("/dev/ttyACM1".into());
        for name in ["/dev/ttyACM1", "serial:///dev/ttyACM1"] {
            assert_eq!(name.parse(), Ok(serial.clone()));
        }
        assert_eq!(serial.to_string(), "/dev/ttyACM1");
        let tcp: Port = "tcp://127.0.0.1:7000".parse().unwrap();
        assert_eq!(tcp.to_string(), "tcp://127.0.0.1:7000");
        assert_eq!("serial:".parse(), Ok(Port::Board));
        for wrong in ["", "udp://127.0.0.1:1", "ttyUSB0", "sim:", "usb:"] {
            let error = wrong.parse::<Port>().unwrap_err();
            assert_eq!(error, PortError::NoBus(wrong.into()));
        }
        for wrong in ["serial://", "tcp://127.0.0.1"] {
            let error = wrong.parse::<Port>().unwrap_err();
            assert!(matches!(error, PortError::Link(_)), "{wrong}: {error}");
        }
    }

    #[test]
    fn a_missing_device_is_named() {
        let port = Port::Serial("/dev/no-such-device".into());
        let error = port.open(1_000_000).err().unwrap().to_string();
        assert!(
            error.contains("/dev/no-such-device") && error.contains("plugged in"),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_opened_once() {
        let pty = crate::pty::Pty::open().unwrap();
        let path = Path::new(pty.name());
        let held = open_device(path, 1_000_000).unwrap();
        let error = open_device(path, 1_000_000).err().unwrap().to_string();
        assert!(
            error.contains(pty.name()) && error.contains("in use by another program"),
            "{error}"
        );
        drop(held);
        assert!(open_device(path, 1_000_000).is_ok());
    }

    #[test]
    fn a_slow_latency_timer_is_pointed_out() {
        let root = std::env::temp_dir().join(format!("latency-{}", std::process::id()));
        let terminals = root.join("tty");
        let folder = terminals.join("ttyUSB7/device");
        std::fs::create_dir_all(&folder).unwrap();
        let device = root.join("ttyUSB7");
        std::fs::write(&device, "").unwrap();
        assert_eq!(LatencyTimer::of(&device, &terminals), None);
        for (text, hints) in [("16\n", true), ("1\n", false)] {
            std::fs::write(folder.join("latency_timer"), text).unwrap();
            let timer = LatencyTimer::of(&device, &terminals).unwrap();
            let hint = timer.hint().unwrap_or_default();
            assert_eq!(hint.contains("latency_timer"), hints, "{hint}");
            assert_eq!(hint.contains("16 ms"), hints, "{hint}");
        }
        std::fs::remove_dir_all(&root).unwrap();
    }
}
