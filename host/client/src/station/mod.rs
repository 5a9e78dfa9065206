//! A host that does what it is asked to, one request at a time: what dashboards,
//! servers and one-line commands put on a link. What the board says, they hear by a
//! [`Tap`](crate::Tap).
//!
//! | module     | what                                                            |
//! |------------|-----------------------------------------------------------------|
//! | [`desk`]   | requests in order, the session, stopping and leaving            |

//!
//! A station never arms the board by itself: what was asked for before the link broke,
//! or before the board was reset, is forgotten.

pub mod desk;

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use armbridge_shared::link::message::Command;

use crate::Host;
use crate::error::OperatorError;
use crate::interrupt;
use desk::Desk;

/// What can be asked of a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// Tell the board this, again and again until it answers.
    Command(Command),
    /// Arm, with the session that the board has told.
    Arm,
    /// Emergency stop, at once.
    Stop,
    /// Disarm, say goodbye and be done.
    Leave,
}

/// Where requests are put.
pub type Controls = Sender<Request>;

/// How often it looks for requests: a key press is obeyed at once, for the eye.
const LOOK_US: u64 = 10_000;

/// The host.
#[derive(Debug)]
pub struct Station {
    requests: Receiver<Request>,
    desk: Desk,
    look_us: u64,
}

impl Station {
    /// A station that has not spoken yet, and where to put requests to it. With all
    /// controls dropped, it leaves.
    pub fn new() -> (Self, Controls) {
        let (controls, requests) = channel();
        let station = Self {
            requests,
            desk: Desk::default(),
            look_us: 0,
        };
        (station, controls)
    }

    fn look(&mut self, now_us: u64) {
        if interrupt::is_raised() {
            self.desk.ask(now_us, Request::Leave);
        }
        loop {
            match self.requests.try_recv() {
                Ok(request) => self.desk.ask(now_us, request),
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.desk.ask(now_us, Request::Leave);
                    return;
                }
            }
        }
    }
}

impl Host for Station {
    type Error = OperatorError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], OperatorError> {
        self.look(now_us);
        self.look_us = now_us + LOOK_US;
        self.desk.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), OperatorError> {
        self.desk.receive(now_us, bytes, |_| {})
    }

    fn wake_at_us(&self) -> u64 {
        self.look_us.min(self.desk.wake_at_us())
    }

    fn is_done(&self) -> bool {
        self.desk.is_done()
    }

    fn parted(&mut self, now_us: u64) {
        self.desk.parted(now_us);
    }
}
