//! Links that are byte streams, opened.

use std::time::Duration;

#[cfg(unix)]
use super::terminal::Terminal;
use super::usb_discovery;
use super::{LinkUri, usb};
use crate::servo_bus::line::{Line, TcpLine};
use crate::servo_bus::port::open_device;

/// How long a socket may take none of our bytes: a host has little to say, and a peer
/// that does not take that is gone.
const STUCK: Duration = Duration::from_secs(1);
/// Rate of a link over a real serial line: what records at 1 kHz need. Over USB and on
/// pseudo-terminals it means nothing.
const BAUD: u32 = 2_000_000;

/// Opens one link, again and again.
pub(super) struct Opener<'a> {
    uri: &'a LinkUri,
    /// Made for this link, and kept, so that its name stays.
    #[cfg(unix)]
    terminal: Option<Terminal>,
}

impl<'a> Opener<'a> {
    pub(super) fn new(uri: &'a LinkUri) -> Self {
        Self {
            uri,
            #[cfg(unix)]
            terminal: None,
        }
    }

    /// Opens it, or says why not and what to do.
    pub(super) fn open(&mut self) -> Result<Box<dyn Line>, String> {
        match self.uri {
            LinkUri::Usb(serial) => boxed(usb::open(serial.as_deref())),
            LinkUri::Serial(None) => {
                let found = usb_discovery::find().map_err(|error| error.to_string())?;
                if found.has_pipes {
                    boxed(usb::open(found.serial.as_deref()))
                } else {
                    boxed(open_device(&found.terminal, BAUD))
                }
            }
            LinkUri::Tcp(endpoint) => {
                let stream = endpoint.connect().map_err(|error| error.to_string())?;
                let limited = stream.set_write_timeout(Some(STUCK));
                boxed(limited.map(|()| TcpLine::new(stream)))
            }
            LinkUri::Serial(Some(path)) | LinkUri::Pty(Some(path)) => {
                boxed(open_device(path, BAUD))
            }
            LinkUri::Pty(None) => self.open_terminal(),
        }
    }

    #[cfg(unix)]
    fn open_terminal(&mut self) -> Result<Box<dyn Line>, String> {
        let terminal = match &mut self.terminal {
            Some(terminal) => terminal,
            none => none.insert(Terminal::new()?),
        };
        boxed(terminal.open())
    }

    #[cfg(not(unix))]
    fn open_terminal(&mut self) -> Result<Box<dyn Line>, String> {
        Err("there are no pseudo-terminals on this system: use tcp://HOST:PORT".into())
    }
}

fn boxed<L: Line + 'static, E: ToString>(line: Result<L, E>) -> Result<Box<dyn Line>, String> {
    match line {
        Ok(line) => Ok(Box::new(line)),
        Err(error) => Err(error.to_string()),
    }
}
