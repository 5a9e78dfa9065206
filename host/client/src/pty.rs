//! A pseudo-terminal: a byte stream with the name of a serial port.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Initial rate, until the other side sets one: that of a servo ex works.
const BAUD: u32 = 1_000_000;

/// State of a pseudo-terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ready {
    /// Bytes.
    Bytes,
    /// No bytes in the given time.
    Nothing,
    /// No program has it open.
    Nobody,
}

/// Both ends of a raw pseudo-terminal.
#[derive(Debug)]
pub struct Pty {
    controller: OwnedFd,
    name: String,
    /// Kept open where it does not matter whether a program has opened it: reads from a
    /// controller whose user end is
    /// closed reads errors.
    _user: Option<OwnedFd>,
}

impl Pty {
    /// Opens a new pseudo-terminal in raw mode: no echo, no line editing, unchanged bytes.
    ///
    /// # Errors
    /// If the system has none available.
    pub fn open() -> io::Result<Self> {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&controller)?;
        unlockpt(&controller)?;
        let name = ptsname(&controller, Vec::new())?;
        let user = rustix::fs::open(&*name, OFlags::RDWR | OFlags::NOCTTY, Mode::empty())?;
        let mut terminal = tcgetattr(&user)?;
        terminal.make_raw();
        terminal.set_speed(BAUD)?;
        tcsetattr(&user, OptionalActions::Now, &terminal)?;
        Ok(Self {
            controller,
            name: name.to_string_lossy().into_owned(),
            _user: Some(user),
        })
    }

    /// The same, on which [`wait`](Self::wait) detects whether a program has it open.
    #[must_use]
    pub fn for_one(self) -> Self {
        Self {
            _user: None,
            ..self
        }
    }

    /// Path that other programs open, for example `/dev/pts/3`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Rate that the other side has set; `None` for 0 baud, which hangs
    /// up a telephone.
    pub fn baud(controller: &File) -> Option<u32> {
        let speed = tcgetattr(controller).ok()?.output_speed();
        (speed > 0).then_some(speed)
    }

    /// A handle on our end.
    ///
    /// # Errors
    /// If there are too many handles.
    pub fn controller(&self) -> io::Result<File> {
        self.controller.try_clone().map(File::from)
    }

    /// Waits for bytes, at most this long.
    ///
    /// # Errors
    /// If the system call fails.
    pub fn wait(&self, longest: Duration) -> io::Result<Ready> {
        let mut ends = [PollFd::new(&self.controller, PollFlags::IN)];
        let longest = Timespec::try_from(longest).map_err(io::Error::other)?;
        match poll(&mut ends, Some(&longest)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let events = ends[0].revents();
        Ok(if events.contains(PollFlags::IN) {
            Ready::Bytes
        } else if events.contains(PollFlags::HUP) {
            Ready::Nobody
        } else {
            Ready::Nothing
        })
    }
}
