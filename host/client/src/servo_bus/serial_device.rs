//! Serial device: opened exclusively, at a rate, with the latency of its adapter.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serial2::SerialPort;

use super::line::{Line, SerialLine};
use crate::transport::usb_discovery;

/// Reason for which a serial device does not open.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// The system does not open it.
    #[error("cannot open {}: {error}; {}", path.display(), advice(path, error))]
    Open {
        /// Its path.
        path: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// Another program uses it.
    #[error("{} is in use by another program; end that one first", .0.display())]
    Busy(PathBuf),
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

fn advice(path: &Path, error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound if path.starts_with("/dev/pts") => {
            "does the program that offers this pseudo-terminal still run?"
        }
        io::ErrorKind::NotFound if cfg!(windows) => {
            "is it plugged in? See the ports in the Device Manager"
        }
        io::ErrorKind::NotFound => "is it plugged in? See /dev/serial/by-id",
        io::ErrorKind::PermissionDenied => {
            "you may have to be in its group, often `dialout`: see `ls -l`"
        }
        _ => "is it a serial device?",
    }
}

/// Opens a serial device exclusively.
///
/// # Errors
/// If it does not open, is in use, or does not support this rate.
pub fn open(path: &Path, baud: u32) -> Result<SerialLine, DeviceError> {
    let failed = |error: io::Error| match error.kind() {
        io::ErrorKind::ResourceBusy | io::ErrorKind::WouldBlock => DeviceError::Busy(path.into()),
        // Windows opens a port once, and denies access to others.
        io::ErrorKind::PermissionDenied if cfg!(windows) => DeviceError::Busy(path.into()),
        _ => DeviceError::Open {
            path: path.into(),
            error,
        },
    };
    let device = SerialPort::open(path, serial2::KeepSettings).map_err(failed)?;
    take(&device).map_err(failed)?;
    let latency = LatencyTimer::read(path).map_or(Duration::ZERO, |timer| timer.value);
    let mut line = SerialLine::new(device, baud, latency);
    match line.set_baud(baud) {
        Ok(_) => Ok(line),
        Err(error) => Err(DeviceError::Baud {
            path: path.into(),
            baud,
            error,
        }),
    }
}

/// Names of the serial ports that this system lists, by number; none where it lists none.
pub fn names() -> Vec<String> {
    let ports = SerialPort::available_ports().unwrap_or_default();
    let mut names: Vec<String> = ports.iter().map(|it| it.display().to_string()).collect();
    names.sort_by_key(|name| (name.len(), name.clone()));
    names
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
    /// Timer of the device `path`, if it has one.
    pub(super) fn read(path: &Path) -> Option<Self> {
        Self::find(path, Path::new(usb_discovery::TERMINALS))
    }

    fn find(path: &Path, terminals: &Path) -> Option<Self> {
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

    #[cfg(unix)]
    #[test]
    fn a_device_is_opened_once() {
        let pty = crate::pty::Pty::open().unwrap();
        let path = Path::new(pty.name());
        let held = open(path, 1_000_000).unwrap();
        let error = open(path, 1_000_000).err().unwrap().to_string();
        assert!(
            error.contains(pty.name()) && error.contains("in use by another program"),
            "{error}"
        );
        drop(held);
        assert!(open(path, 1_000_000).is_ok());
    }

    #[test]
    fn a_slow_latency_timer_is_pointed_out() {
        let root = std::env::temp_dir().join(format!("latency-{}", std::process::id()));
        let terminals = root.join("tty");
        let folder = terminals.join("ttyUSB7/device");
        std::fs::create_dir_all(&folder).unwrap();
        let device = root.join("ttyUSB7");
        std::fs::write(&device, "").unwrap();
        assert_eq!(LatencyTimer::find(&device, &terminals), None);
        for (text, hints) in [("16\n", true), ("1\n", false)] {
            std::fs::write(folder.join("latency_timer"), text).unwrap();
            let timer = LatencyTimer::find(&device, &terminals).unwrap();
            let hint = timer.hint().unwrap_or_default();
            assert_eq!(hint.contains("latency_timer"), hints, "{hint}");
            assert_eq!(hint.contains("16 ms"), hints, "{hint}");
        }
        std::fs::remove_dir_all(&root).unwrap();
    }
}
