//! Boards by name.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use armbridge_client::transport::{LinkUri, LinkUriError};

/// All that a board can be, for errors and help.
pub const CHOICES: &str = "usb:, usb:SERIAL, serial:, serial:///dev/ttyACM0, tcp://HOST:PORT, \
                           pty:, pty:///dev/pts/3, sim:, emulate: or emulate:IMAGE";

/// Name of a board, real or simulated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BoardUri {
    /// At this link.
    Link(LinkUri),
    /// The bench.
    Sim,
    /// The emulator, with this image or the one that was built last.
    Emulate(Option<PathBuf>),
}

/// Why a name is not a board.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoardUriError {
    /// A scheme that there is not, or none.
    #[error("`{0}` is no link: expected {CHOICES}")]
    Scheme(String),
    /// A link that cannot be.
    #[error(transparent)]
    Link(LinkUriError),
    /// Something follows where nothing can.
    #[error("nothing can follow `sim:`, but `{0}` does: options of the bench are given apart")]
    Sim(String),
    /// A path with nothing in it.
    #[error("`{0}` names no image: write emulate:IMAGE or emulate: alone")]
    NoImage(String),
}

impl FromStr for BoardUri {
    type Err = BoardUriError;

    fn from_str(name: &str) -> Result<Self, BoardUriError> {
        match name.split_once(':') {
            Some(("sim", "" | "//")) => Ok(Self::Sim),
            Some(("sim", rest)) => Err(BoardUriError::Sim(rest.into())),
            Some(("emulate", "")) => Ok(Self::Emulate(None)),
            Some(("emulate", "//")) => Err(BoardUriError::NoImage(name.into())),
            Some(("emulate", image)) => {
                let image = image.strip_prefix("//").unwrap_or(image);
                Ok(Self::Emulate(Some(image.into())))
            }
            _ => name.parse().map(Self::Link).map_err(|error| match error {
                LinkUriError::Scheme(name) => BoardUriError::Scheme(name),
                error => BoardUriError::Link(error),
            }),
        }
    }
}

impl BoardUri {
    /// Whether the arm is simulated as far as this program knows: behind a socket or a
    /// terminal there may be a real one.
    pub fn is_simulated(&self) -> bool {
        match self {
            Self::Sim | Self::Emulate(_) => true,
            Self::Link(_) => false,
        }
    }

    /// Where code and arm are, in words: whatever is simulated is called so.
    pub fn world(&self) -> String {
        match self {
            Self::Sim => "simulated: bench".into(),
            Self::Emulate(_) => "simulated: QEMU mps2-an386".into(),
            Self::Link(link) => format!("a board on {link}"),
        }
    }
}

impl fmt::Display for BoardUri {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(link) => link.fmt(f),
            Self::Sim => write!(f, "sim:"),
            Self::Emulate(None) => write!(f, "emulate:"),
            Self::Emulate(Some(image)) => write!(f, "emulate:{}", image.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written() {
        for (name, board) in [
            ("sim:", BoardUri::Sim),
            ("emulate:", BoardUri::Emulate(None)),
            ("emulate:a/b.elf", BoardUri::Emulate(Some("a/b.elf".into()))),
            ("usb:", BoardUri::Link(LinkUri::Usb(None))),
        ] {
            assert_eq!(name.parse(), Ok(board.clone()), "{name}");
            assert_eq!(board.to_string(), name);
        }
        assert_eq!("sim://".parse(), Ok(BoardUri::Sim));
    }

    #[test]
    fn mistakes_say_what_is_possible() {
        for (name, words) in [
            ("", "expected usb:"),
            ("sym:", "emulate:IMAGE"),
            ("sim:9", "nothing can follow"),
            ("emulate://", "emulate:IMAGE"),
            ("serial://", "serial:///dev/..."),
        ] {
            let error = name.parse::<BoardUri>().unwrap_err().to_string();
            assert!(error.contains(words), "{name}: {error}");
            assert!(!error.contains('\n'));
        }
    }
}
