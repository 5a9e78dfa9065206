//! A link on a pseudo-terminal that is made for it, and waits for somebody.

use std::fs::File;
use std::io::{self, Read, Write};
use std::rc::Rc;
use std::time::{Duration, Instant};

use crate::interrupt;
use crate::pty::{Pty, Ready};
use crate::servo_bus::Line;
use crate::servo_bus::line::taken;

/// Between two looks whether somebody has it open.
const LOOK: Duration = Duration::from_millis(20);
/// Longest read.
const CHUNK: usize = 4_096;

/// A terminal, again and again for whoever opens it.
#[derive(Debug)]
pub(super) struct Terminal {
    pty: Rc<Pty>,
    was_open: bool,
}

impl Terminal {
    /// Makes one, and says on standard error what it is called.
    pub(super) fn new() -> Result<Self, String> {
        let pty = Pty::open().map_err(|error| {
            format!("the system gives no pseudo-terminal: {error}; use tcp:// instead")
        })?;
        let pty = Rc::new(pty.for_one());
        eprintln!("{} waits for somebody to open it", pty.name());
        Ok(Self {
            pty,
            was_open: false,
        })
    }

    /// A line to whoever has it open. The first is waited for, until ctrl-c.
    pub(super) fn open(&mut self) -> Result<TerminalLine, String> {
        let failed = |error: io::Error| format!("{}: {error}", self.pty.name());
        while self.pty.wait(Duration::ZERO).map_err(failed)? == Ready::Nobody {
            if self.was_open {
                return Err(format!("nobody has {} open", self.pty.name()));
            }
            if interrupt::is_raised() {
                return Err(format!(
                    "ctrl-c was pressed before anybody opened {}",
                    self.pty.name()
                ));
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

/// Our end, while somebody has the other.
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
            Ready::Bytes => {
                let mut bytes = vec![0; CHUNK];
                let came = self.controller.read(&mut bytes);
                taken(came, bytes)
            }
        }
    }

    fn set_baud(&mut self, _baud: u32) -> io::Result<bool> {
        Ok(false)
    }

    fn baud(&self) -> Option<u32> {
        None
    }

    fn latency(&self) -> Duration {
        Duration::ZERO
    }
}
