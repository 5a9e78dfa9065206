//! The bus by its name: `tcp://HOST:PORT`, or a serial device's path.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use serial2::SerialPort;

use super::line::{Line, SerialLine, TcpLine};
use crate::endpoint::{Endpoint, EndpointError, OpenError};

/// Where the bus is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Port {
    /// Behind a socket.
    Tcp(Endpoint),
    /// Behind a serial device.
    Serial(PathBuf),
}

/// Why a name is not a port.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// A scheme that there is not.
    #[error("expected tcp://HOST:PORT or a serial device, for example /dev/ttyUSB0")]
    Scheme,
    /// What follows `tcp://` is not an address.
    #[error(transparent)]
    Endpoint(#[from] EndpointError),
}

impl FromStr for Port {
    type Err = PortError;

    fn from_str(name: &str) -> Result<Self, PortError> {
        match name.split_once("://") {
            Some(("tcp", _)) => Ok(Self::Tcp(name.parse()?)),
            Some(("serial", path)) if !path.is_empty() => Ok(Self::Serial(path.into())),
            None if !name.is_empty() => Ok(Self::Serial(name.into())),
            _ => Err(PortError::Scheme),
        }
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(endpoint) => endpoint.fmt(f),
            Self::Serial(path) => path.display().fmt(f),
        }
    }
}

/// Why a port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortOpenError {
    /// Nobody behind the socket.
    #[error(transparent)]
    Tcp(#[from] OpenError),
    /// The device does not open.
    #[error("cannot open {}: {error}; {}", path.display(), advice(error))]
    Serial {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It opens, but not at this rate.
    #[error("{} does not run at {baud} baud: {error}", path.display())]
    Baud {
        /// Its path.
        path: PathBuf,
        /// The rate that was asked for.
        baud: u32,
        /// What the system says.
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
    /// Opens it, a serial device at `baud`.
    ///
    /// # Errors
    /// If it does not open.
    pub fn open(&self, baud: u32) -> Result<Box<dyn Line>, PortOpenError> {
        let path = match self {
            Self::Tcp(endpoint) => return Ok(Box::new(TcpLine::new(endpoint.connect()?))),
            Self::Serial(path) => path.clone(),
        };
        let device = match SerialPort::open(&path, serial2::KeepSettings) {
            Ok(device) => device,
            Err(error) => return Err(PortOpenError::Serial { path, error }),
        };
        let latency = self
            .latency_timer()
            .map_or(Duration::ZERO, |timer| timer.value);
        let mut line = SerialLine::new(device, baud, latency);
        match line.set_baud(baud) {
            Ok(_) => Ok(Box::new(line)),
            Err(error) => Err(PortOpenError::Baud { path, baud, error }),
        }
    }

    /// The adapter's latency timer, if it has one that can be seen.
    pub fn latency_timer(&self) -> Option<LatencyTimer> {
        match self {
            Self::Tcp(_) => None,
            Self::Serial(path) => LatencyTimer::of(path, Path::new("/sys/class/tty")),
        }
    }
}

/// For how long an FTDI adapter collects bytes before it hands them on. Linux
/// sets it to 16 ms, which every answer then takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LatencyTimer {
    /// File in which it can be changed.
    pub file: PathBuf,
    /// How long.
    pub value: Duration,
}

impl LatencyTimer {
    /// Of the device `path`, in the system's list of terminals.
    fn of(path: &Path, terminals: &Path) -> Option<Self> {
        let device = path.canonicalize().ok()?;
        let file = terminals
            .join(device.file_name()?)
            .join("device/latency_timer");
        let text = std::fs::read_to_string(&file).ok()?;
        let value = Duration::from_millis(text.trim().parse().ok()?);
        Some(Self { file, value })
    }

    /// What to do about it, if anything.
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
        for wrong in ["", "udp://127.0.0.1:1", "serial://"] {
            assert_eq!(wrong.parse::<Port>(), Err(PortError::Scheme), "{wrong}");
        }
        assert!("tcp://127.0.0.1".parse::<Port>().is_err());
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
