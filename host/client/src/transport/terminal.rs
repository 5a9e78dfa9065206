//! Link on a new pseudo-terminal, which another program opens.

use std::fs::File;
use std::io::{self, Write};
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::{LinkUri, TransportError};
use crate::pty::{Pty, Ready};
use crate::servo_bus::Line;
use crate::servo_bus::line::read_chunk;
use crate::{ctrl_c, stdio};

/// Interval between two checks whether it is open.
const LOOK: Duration = Duration::from_millis(20);

/// A pseudo-terminal that is opened repeatedly.
#[derive(Debug)]
pub(super) struct Terminal {
    pty: Rc<Pty>,
    link: LinkUri,
    was_open: bool,
}

impl Terminal {
    /// Creates one, and prints its name on standard error.
    pub(super) fn new() -> Result<Self, TransportError> {
        let pty = Pty::open().map_err(TransportError::NoTerminal)?;
        let pty = Rc::new(pty.for_one());
        stdio::note(format_args!(
            "{} waits for a program to open it",
            pty.name()
        ));
        Ok(Self {
            link: LinkUri::Pty(Some(pty.name().into())),
            pty,
            was_open: false,
        })
    }

    /// Its name for other programs.
    pub(super) fn link(&self) -> &LinkUri {
        &self.link
    }

    /// A line to the program that has it open. Waits for the first, until ctrl-c.
    pub(super) fn open(&mut self) -> Result<TerminalLine, TransportError> {
        let name = || self.pty.name().to_owned();
        let failed = |source| TransportError::Terminal {
            name: name(),
            source,
        };
        while self.pty.wait(Duration::ZERO).map_err(failed)? == Ready::Nobody {
            if self.was_open {
                return Err(TransportError::NotOpen(name()));
            }
            if ctrl_c::is_raised() {
                return Err(TransportError::Interrupted(name()));
            }
            std::thread::sleep(LOOK);
        }
        self.was_open = true;
        Ok(TerminalLine {
            controller: self.pty.controller().map_err(failed)?,
            pty: Rc::clone(&self.pty),
        })
    }
}

/// Our end, while the other is open.
#[derive(Debug)]
pub(super) struct TerminalLine {
    pty: Rc<Pty>,
    controller: File,
}

impl Line for TerminalLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.controller.write_all(bytes)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>> {
        let wait = until.saturating_duration_since(Instant::now());
        match self.pty.wait(wait)? {
            Ready::Nothing => Ok(Vec::new()),
            Ready::Nobody => Err(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                "the other side closed it",
            )),
            Ready::Bytes => read_chunk(&mut self.controller),
        }
    }
}
