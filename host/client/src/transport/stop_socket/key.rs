//! Key of a board: the same for all URIs of its link, and short enough for a socket's name.

use std::fmt;
use std::path::Path;

use armbridge_link::crc32;

use super::super::{LinkUri, usb, usb_discovery};

/// Longest key: a socket's path has about 100 bytes, and a folder for temporary files on
/// macOS, the process and the ending take the others.
const LENGTH_MAX: usize = 24;
/// Prefix that is kept of a longer key, before its checksum.
const PREFIX: usize = 14;

/// Name of a board, such as `/dev/ttyACM0`, `usb:A1`, `tcp:127.0.0.1:7001` or `sim:`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardKey(String);

impl BoardKey {
    /// Of this link; `None` for a new pseudo-terminal, and where no board is found.
    pub fn of(link: &LinkUri) -> Option<Self> {
        match link {
            LinkUri::Serial(Some(path)) | LinkUri::Pty(Some(path)) => Some(Self::of_path(path)),
            LinkUri::Serial(None) if usb_discovery::IS_SUPPORTED => {
                let found = usb_discovery::find().ok()?;
                Some(Self::of_found(&found))
            }
            LinkUri::Usb(Some(serial)) => Some(Self::of_usb(Some(serial))),
            LinkUri::Usb(None) | LinkUri::Serial(None) => {
                Some(Self::of_usb(usb::serial_of_the_only_one().as_deref()))
            }
            LinkUri::Tcp(endpoint) => {
                let at = endpoint.to_string();
                Some(Self::of_text(&at.replacen("tcp://", "tcp:", 1)))
            }
            LinkUri::Pty(None) => None,
        }
    }

    /// Of a simulated board that is in one process alone.
    pub fn of_simulation(scheme: &str) -> Self {
        Self::of_text(scheme)
    }

    /// Of a board that is plugged in.
    pub fn of_found(found: &usb_discovery::Found) -> Self {
        if found.has_pipes {
            Self::of_usb(found.serial.as_deref())
        } else {
            Self::of_path(&found.terminal)
        }
    }

    fn of_path(path: &Path) -> Self {
        let path = path.canonicalize().unwrap_or_else(|_| path.into());
        Self::of_text(&path.to_string_lossy())
    }

    fn of_usb(serial: Option<&str>) -> Self {
        Self::of_text(&format!("usb:{}", serial.unwrap_or_default()))
    }

    fn of_text(text: &str) -> Self {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "/:.-_".contains(c);
        if text.len() <= LENGTH_MAX && text.chars().all(is_plain) {
            return Self(text.into());
        }
        let prefix = text.chars().filter(|c| is_plain(*c)).take(PREFIX);
        let sum = crc32::checksum(text.as_bytes());
        Self(format!("{}~{sum:08x}", prefix.collect::<String>()))
    }

    /// Of a part of a socket's name.
    pub(super) fn from_name(name: &str) -> Self {
        Self(name.replace('+', "/"))
    }

    /// The link to a socket, which others may open too; `None` for a key that is shortened.
    pub fn tcp_link(&self) -> Option<LinkUri> {
        let at = self.0.strip_prefix("tcp:")?;
        format!("tcp://{at}").parse().ok()
    }

    /// As a user reads it.
    pub fn in_words(&self) -> &str {
        &self.0
    }
}

/// As a part of a socket's name, without slashes.
impl fmt::Display for BoardKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.replace('/', "+"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(link: &str) -> BoardKey {
        BoardKey::of(&link.parse().unwrap()).unwrap()
    }

    #[test]
    fn all_uris_of_a_link_have_one_key() {
        assert_eq!(key("serial:///dev/null"), key("pty:///dev/null"));
        assert_eq!(key("serial:///dev/null").in_words(), "/dev/null");
        assert_eq!(key("usb:A1").in_words(), "usb:A1");
        assert_eq!(key("tcp://127.0.0.1:7001").in_words(), "tcp:127.0.0.1:7001");
        let tcp = "tcp://127.0.0.1:7001";
        assert_eq!(key(tcp).tcp_link(), tcp.parse().ok());
        assert_eq!(BoardKey::of(&LinkUri::Pty(None)), None);
    }

    #[test]
    fn a_long_or_strange_key_is_short_and_its_own() {
        let long = [
            "tcp://[fd12:3456:789a:1:2:3:4:5]:7001",
            "tcp://[fd12:3456:789a:1:2:3:4:5]:7002",
            "serial:///dev/a #b%c+d",
            "serial:///dev/a #b%c+e",
        ];
        let keys = long.map(key);
        for (i, key) in keys.iter().enumerate() {
            assert!(key.in_words().len() <= LENGTH_MAX);
            assert_eq!(BoardKey::from_name(&key.to_string()), *key);
            assert!(keys[..i].iter().all(|other| other != key));
        }
    }
}
