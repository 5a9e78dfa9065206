//! Port of the bus by its name: a serial device, a pseudo-terminal or a socket, named like
//! a link ([`LinkUri`]).

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::line::{Line, TcpLine};
use super::serial_device::{self, DeviceError, LatencyTimer};
use crate::endpoint::{Endpoint, OpenError};
use crate::transport::device_names::DEVICE;
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
         port, or a serial device such as {DEVICE}"
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
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// There is no board, or more than one.
    #[error(transparent)]
    Find(#[from] FindError),
}

impl Port {
    /// Opens it, a serial device at `baud` and exclusively.
    ///
    /// # Errors
    /// If it does not open.
    pub fn open(&self, baud: u32) -> Result<Box<dyn Line>, PortOpenError> {
        match self {
            Self::Tcp(endpoint) => Ok(Box::new(TcpLine::new(endpoint.connect()?))),
            Self::Serial(path) => Ok(Box::new(serial_device::open(path, baud)?)),
            Self::Board => Ok(Box::new(serial_device::open(
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
            Self::Serial(path) => LatencyTimer::read(path),
        }
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
}
