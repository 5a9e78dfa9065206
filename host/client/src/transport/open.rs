//! Opening of links that are byte streams.

use std::time::Duration;

#[cfg(unix)]
use super::terminal::Terminal;
use super::{LinkUri, TransportError, usb, usb_discovery};
use crate::servo_bus::line::{Line, TcpLine};
use crate::servo_bus::serial_device;

/// Longest time for which a socket may accept no bytes: a host sends few, and a peer
/// that does not take them is gone.
const STUCK: Duration = Duration::from_secs(1);
/// Baud rate of a link over a real serial line: needed for records at 1 kHz. Over USB and on
/// pseudo-terminals it has no effect.
const BAUD: u32 = 2_000_000;

/// Opens one link, repeatedly.
pub(super) struct Opener<'a> {
    uri: &'a LinkUri,
    /// Kept, so that its name stays the same.
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

    /// Name under which another program could open the link.
    pub(super) fn name(&self) -> &LinkUri {
        #[cfg(unix)]
        if let Some(terminal) = &self.terminal {
            return terminal.link();
        }
        self.uri
    }

    /// Opens the link.
    pub(super) fn open(&mut self) -> Result<Box<dyn Line>, TransportError> {
        Ok(match self.uri {
            LinkUri::Usb(serial) => Box::new(usb::open(serial.as_deref())?),
            LinkUri::Serial(None) if !usb_discovery::IS_SUPPORTED => Box::new(usb::open(None)?),
            LinkUri::Serial(None) => {
                let found = usb_discovery::find()?;
                if found.has_pipes {
                    Box::new(usb::open(found.serial.as_deref())?)
                } else {
                    Box::new(serial_device::open(&found.terminal, BAUD)?)
                }
            }
            LinkUri::Tcp(endpoint) => {
                let stream = endpoint.connect()?;
                stream.set_write_timeout(Some(STUCK))?;
                Box::new(TcpLine::new(stream))
            }
            LinkUri::Serial(Some(path)) | LinkUri::Pty(Some(path)) => {
                Box::new(serial_device::open(path, BAUD)?)
            }
            LinkUri::Pty(None) => self.open_terminal()?,
        })
    }

    #[cfg(unix)]
    fn open_terminal(&mut self) -> Result<Box<dyn Line>, TransportError> {
        let terminal = match &mut self.terminal {
            Some(terminal) => terminal,
            none => none.insert(Terminal::new()?),
        };
        Ok(Box::new(terminal.open()?))
    }

    #[cfg(not(unix))]
    fn open_terminal(&mut self) -> Result<Box<dyn Line>, TransportError> {
        Err(TransportError::NoTerminals)
    }
}
