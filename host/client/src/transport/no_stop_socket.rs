//! Emergency stop of a link that another process has: not on this system, which has no
//! Unix domain sockets.

use std::io;

use super::LinkUri;

/// Answer of a link's owner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StopAnswer {
    /// The board reports this fault, by its name.
    Stopped(String),
    /// The stop is not known to have reached the board, for this reason.
    Failed(String),
}

/// Never asks anybody.
pub fn ask(_link: &LinkUri) -> Option<StopAnswer> {
    None
}

/// No listener.
#[derive(Debug)]
pub(super) enum StopListener {}

impl StopListener {
    pub(super) fn open(_link: &LinkUri) -> io::Result<Option<Self>> {
        Ok(None)
    }

    pub(super) fn is_stop_due(&mut self) -> bool {
        match *self {}
    }

    pub(super) fn receive(&mut self, _bytes: &[u8]) {
        match *self {}
    }

    pub(super) fn refuse(&mut self) {
        match *self {}
    }
}
