//! URIs of boards.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use armbridge_client::endpoint::{Endpoint, EndpointError};
use armbridge_client::transport::stop_socket::BoardKey;
use armbridge_client::transport::{LinkUri, LinkUriError};

/// All forms of a board's URI, for errors and help.
#[cfg(windows)]
pub const CHOICES: &str = "usb:, usb:SERIAL, serial:, serial:COM3, tcp://HOST:PORT or sim:";
/// All forms of a board's URI, for errors and help.
#[cfg(not(windows))]
pub const CHOICES: &str = "usb:, usb:SERIAL, serial:, serial:///dev/ttyACM0, tcp://HOST:PORT, \
                           pty:, pty:///dev/pts/3, sim:, emulate: or emulate:IMAGE";

/// URI of a board, real or simulated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BoardUri {
    /// At this link.
    Link(LinkUri),
    /// The bench.
    Sim,
    /// The firmware image under QEMU.
    Emulate(EmulatorUri),
}

/// URI of an emulated board: `emulate:IMAGE?icount`,
/// `emulate:IMAGE?bus=tcp://HOST:PORT&slow=50`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EmulatorUri {
    /// The image; `None` for the one of the source tree that the program is called in.
    pub image: Option<PathBuf>,
    /// Each instruction takes 8 ns of virtual time, so that measured compute times
    /// repeat.
    pub icount: bool,
    /// An external servo bus, in wall-clock time, instead of the bench's.
    pub bus: Option<ExternalBus>,
}

/// A servo bus behind a socket.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExternalBus {
    /// Raw bus bytes.
    pub at: Endpoint,
    /// Ratio of wall-clock time to the board's time.
    pub slow: u32,
}

/// Slowness of an emulated board on an external bus with real byte times.
const SLOW: u32 = 50;

/// Error in a board's URI.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoardUriError {
    /// An unknown scheme, or none.
    #[error("`{0}` is no link: expected {CHOICES}")]
    Scheme(String),
    /// An invalid link.
    #[error(transparent)]
    Link(LinkUriError),
    /// Text after `sim:`.
    #[error("nothing can follow `sim:`, but `{0}` does: options of the bench are given apart")]
    Sim(String),
    /// An empty path.
    #[error("`{0}` names no image: write emulate:IMAGE or emulate: alone")]
    NoImage(String),
    /// An unknown option.
    #[error(
        "`{0}` is no option of emulate: expected icount, bus=tcp://HOST:PORT or slow=TIMES, with & \
         between"
    )]
    Option(String),
    /// The address of an external bus.
    #[error("the bus of emulate: {0}")]
    Bus(#[from] EndpointError),
}

impl FromStr for BoardUri {
    type Err = BoardUriError;

    fn from_str(name: &str) -> Result<Self, BoardUriError> {
        match name.split_once(':') {
            Some(("sim", "" | "//")) => Ok(Self::Sim),
            Some(("sim", rest)) => Err(BoardUriError::Sim(rest.into())),
            Some(("emulate", "//")) => Err(BoardUriError::NoImage(name.into())),
            Some(("emulate", rest)) => Ok(Self::Emulate(rest.parse()?)),
            _ => name.parse().map(Self::Link).map_err(|error| match error {
                LinkUriError::Scheme(name) => BoardUriError::Scheme(name),
                error => BoardUriError::Link(error),
            }),
        }
    }
}

impl FromStr for EmulatorUri {
    type Err = BoardUriError;

    /// Parses the text after `emulate:`.
    fn from_str(text: &str) -> Result<Self, BoardUriError> {
        let (image, options) = text.split_once('?').unwrap_or((text, ""));
        let image = image.strip_prefix("//").unwrap_or(image);
        let mut uri = Self {
            image: (!image.is_empty()).then(|| image.into()),
            ..Self::default()
        };
        let mut slow = None;
        for option in options.split('&').filter(|option| !option.is_empty()) {
            let unknown = || BoardUriError::Option(option.into());
            match option.split_once('=') {
                None if option == "icount" => uri.icount = true,
                Some(("bus", at)) => {
                    let (at, slow) = (at.parse()?, SLOW);
                    uri.bus = Some(ExternalBus { at, slow });
                }
                Some(("slow", times)) => {
                    let times = times
                        .parse()
                        .ok()
                        .filter(|times| (1..=10_000).contains(times));
                    slow = Some(times.ok_or_else(unknown)?);
                }
                _ => return Err(unknown()),
            }
        }
        match (&mut uri.bus, slow) {
            (Some(bus), Some(times)) => bus.slow = times,
            (None, Some(times)) => return Err(BoardUriError::Option(format!("slow={times}"))),
            (_, None) => {}
        }
        Ok(uri)
    }
}

impl fmt::Display for EmulatorUri {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(image) = &self.image {
            write!(f, "{}", image.display())?;
        }
        let icount = self.icount.then(|| "icount".to_owned());
        let bus = self
            .bus
            .as_ref()
            .map(|bus| format!("bus={}&slow={}", bus.at, bus.slow));
        let options: Vec<String> = icount.into_iter().chain(bus).collect();
        if options.is_empty() {
            return Ok(());
        }
        write!(f, "?{}", options.join("&"))
    }
}

impl BoardUri {
    /// Whether the arm is known to be simulated: behind a socket or a
    /// terminal there may be a real one.
    pub fn is_simulated(&self) -> bool {
        match self {
            Self::Sim | Self::Emulate(_) => true,
            Self::Link(_) => false,
        }
    }

    /// Whether servos and arm are those of the bench, in this process.
    pub fn has_bench(&self) -> bool {
        match self {
            Self::Sim => true,
            Self::Emulate(emulator) => emulator.bus.is_none(),
            Self::Link(_) => false,
        }
    }

    /// Key by which other programs find its owner; simulated boards of the same kind share
    /// one.
    pub fn key(&self) -> Option<BoardKey> {
        match self {
            Self::Sim => Some(BoardKey::of_simulation("sim:")),
            Self::Emulate(_) => Some(BoardKey::of_simulation("emulate:")),
            Self::Link(link) => BoardKey::of(link),
        }
    }

    /// Where code and arm run, as text; begins with `simulated` for a simulation.
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
            Self::Emulate(emulator) => write!(f, "emulate:{emulator}"),
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
            ("emulate:", BoardUri::Emulate(EmulatorUri::default())),
            (
                "emulate:a/b.elf?icount",
                BoardUri::Emulate(EmulatorUri {
                    image: Some("a/b.elf".into()),
                    icount: true,
                    bus: None,
                }),
            ),
            (
                "emulate:?bus=tcp://127.0.0.1:7000&slow=10",
                BoardUri::Emulate(EmulatorUri {
                    bus: Some(ExternalBus {
                        at: "tcp://127.0.0.1:7000".parse().unwrap(),
                        slow: 10,
                    }),
                    ..EmulatorUri::default()
                }),
            ),
            ("usb:", BoardUri::Link(LinkUri::Usb(None))),
            (
                r"emulate:C:\images\b.elf?icount",
                BoardUri::Emulate(EmulatorUri {
                    image: Some(r"C:\images\b.elf".into()),
                    icount: true,
                    bus: None,
                }),
            ),
        ] {
            assert_eq!(name.parse(), Ok(board.clone()), "{name}");
            assert_eq!(board.to_string(), name);
        }
        assert_eq!("sim://".parse(), Ok(BoardUri::Sim));
    }

    #[test]
    fn errors_list_the_valid_forms() {
        for (name, words) in [
            ("", "expected usb:"),
            ("sym:", "emulate:IMAGE"),
            ("sim:9", "nothing can follow"),
            ("emulate://", "emulate:IMAGE"),
            ("emulate:?fast", "icount, bus="),
            ("emulate:?slow=10", "icount, bus="),
            ("emulate:?bus=udp://x", "tcp://HOST:PORT"),
            ("serial://", "names no device"),
            (r"C:\logs\run.mcap", "is no link"),
        ] {
            let error = name.parse::<BoardUri>().unwrap_err().to_string();
            assert!(error.contains(words), "{name}: {error}");
            assert!(!error.contains('\n'));
        }
    }
}
