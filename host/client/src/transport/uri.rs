//! URIs of links.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::LinkUri;
use super::device_names::SERIAL_LINK;
use crate::endpoint::EndpointError;

/// All forms of a link, for errors and help.
#[cfg(windows)]
pub const CHOICES: &str = "usb:, usb:SERIAL, serial:, serial:COM3 or tcp://HOST:PORT";
/// All forms of a link, for errors and help.
#[cfg(not(windows))]
pub const CHOICES: &str = "usb:, usb:SERIAL, serial:, serial:///dev/ttyACM0, tcp://HOST:PORT, \
                           pty: or pty:///dev/pts/3";

/// Error in a link's URI.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkUriError {
    /// An unknown scheme, or none.
    #[error("`{0}` is no link: expected {CHOICES}")]
    Scheme(String),
    /// An invalid address after `tcp://`.
    #[error(transparent)]
    Endpoint(#[from] EndpointError),
    /// An empty path.
    #[error(
        "`{0}` names no device: write one behind it, as in {SERIAL_LINK}, or {scheme}: alone",
        scheme = .0.split(':').next().unwrap_or_default()
    )]
    NoPath(String),
}

impl FromStr for LinkUri {
    type Err = LinkUriError;

    fn from_str(name: &str) -> Result<Self, LinkUriError> {
        // The plain path of a device is accepted for convenience.
        if name.starts_with('/') || windows_port(name).is_some() {
            return Ok(Self::Serial(Some(device(name))));
        }
        let unknown = || LinkUriError::Scheme(name.into());
        let (scheme, rest) = name.split_once(':').ok_or_else(unknown)?;
        match (scheme, rest) {
            ("tcp", _) => Ok(Self::Tcp(name.parse()?)),
            ("usb", serial) => Ok(Self::Usb(
                some(serial.trim_start_matches('/')).map(str::to_owned),
            )),
            ("serial", rest) => Ok(Self::Serial(path(name, rest)?)),
            ("pty", rest) => Ok(Self::Pty(path(name, rest)?)),
            _ => Err(unknown()),
        }
    }
}

/// The port of Windows with this name, in one spelling: `COM3`, `com3` and `\\.\COM3` are
/// the same.
fn windows_port(name: &str) -> Option<String> {
    let name = name.strip_prefix(r"\\.\").unwrap_or(name);
    let (letters, number) = name.split_at_checked(3)?;
    let is_port = letters.eq_ignore_ascii_case("COM")
        && !number.is_empty()
        && number.bytes().all(|byte| byte.is_ascii_digit());
    is_port.then(|| format!("COM{number}"))
}

fn device(name: &str) -> PathBuf {
    windows_port(name).map_or_else(|| name.into(), PathBuf::from)
}

fn some(text: &str) -> Option<&str> {
    (!text.is_empty()).then_some(text)
}

/// The path after a scheme, with or without `//` before it.
fn path(name: &str, rest: &str) -> Result<Option<PathBuf>, LinkUriError> {
    match rest.strip_prefix("//") {
        Some("") => Err(LinkUriError::NoPath(name.into())),
        Some(path) => Ok(Some(device(path))),
        None => Ok(some(rest).map(device)),
    }
}

impl fmt::Display for LinkUri {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usb(serial) => write!(f, "usb:{}", serial.as_deref().unwrap_or_default()),
            Self::Serial(None) => write!(f, "serial:"),
            Self::Serial(Some(path)) => match path.to_str().and_then(windows_port) {
                Some(port) => write!(f, "serial:{port}"),
                None => write!(f, "serial://{}", path.display()),
            },
            Self::Tcp(endpoint) => endpoint.fmt(f),
            Self::Pty(None) => write!(f, "pty:"),
            Self::Pty(Some(path)) => write!(f, "pty://{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written() {
        for (name, link) in [
            ("usb:", LinkUri::Usb(None)),
            ("usb:A1", LinkUri::Usb(Some("A1".into()))),
            ("serial:", LinkUri::Serial(None)),
            (
                "serial:///dev/ttyACM0",
                LinkUri::Serial(Some("/dev/ttyACM0".into())),
            ),
            ("pty:", LinkUri::Pty(None)),
            ("pty:///dev/pts/3", LinkUri::Pty(Some("/dev/pts/3".into()))),
        ] {
            assert_eq!(name.parse(), Ok(link.clone()), "{name}");
            assert_eq!(link.to_string(), name);
        }
        let tcp: LinkUri = "tcp://127.0.0.1:7000".parse().unwrap();
        assert_eq!(tcp.to_string(), "tcp://127.0.0.1:7000");
        // Other accepted forms.
        for (name, same) in [
            ("/dev/ttyACM0", "serial:///dev/ttyACM0"),
            ("COM3", "serial:COM3"),
            ("com12", "serial:COM12"),
            (r"\\.\COM10", "serial:COM10"),
            ("serial:COM10", "serial:COM10"),
            ("serial://com3", "serial:COM3"),
            ("serial:/dev/ttyACM0", "serial:///dev/ttyACM0"),
        ] {
            assert_eq!(name.parse::<LinkUri>().unwrap().to_string(), same);
        }
    }

    #[test]
    fn errors_list_the_valid_forms() {
        for (name, words) in [
            ("", "expected usb:"),
            ("sym:", CHOICES),
            ("ttyACM0", SERIAL_LINK),
            // A path with a drive is no scheme.
            (r"C:\logs\run.mcap", r"`C:\logs\run.mcap` is no link"),
            ("C:/logs/run.mcap", "is no link"),
            ("COM", "is no link"),
            ("COMPUTER3", "is no link"),
            ("udp://127.0.0.1:1", "tcp://HOST:PORT"),
            ("serial://", SERIAL_LINK),
            ("tcp://127.0.0.1", "HOST:PORT"),
        ] {
            let error = name.parse::<LinkUri>().unwrap_err().to_string();
            assert!(error.contains(words), "{name}: {error}");
            assert!(!error.contains('\n'));
        }
    }
}
