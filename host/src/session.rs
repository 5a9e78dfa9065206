//! A board served by a thread of its own, for whoever has a person to look after.
//!
//! A simulated arm has hands at its side, too: they bring it back to where it began and
//! hold it until it is driven, as somebody would do with a real one, and push it.
//!
//! However the session ends, by a key, an error or a panic, the board is told to disarm
//! and the thread is waited for.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::bench::cosim::Host;
use crate::bench::plant::Push;
use crate::links::{LinkError, LinkUri, Options, drive};
use crate::operator::OperatorError;
use crate::station::{Controls, Request, Station};

/// How long the board may take to say that it is disarmed.
const LEAVE: Duration = Duration::from_secs(3);
/// Between two looks at whether it has.
const LOOK: Duration = Duration::from_millis(10);

/// What a push by a key is: one that a standing arm takes without falling.
const PUSH_NM: f64 = 0.3;
const PUSH_NS: u64 = 200_000_000;

/// What a hand does to a simulated arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// Brings it back to where it began, and holds it until a motor drives it.
    Lift,
    /// Pushes this joint, 0.3 N m for 0.2 s.
    Push(usize),
}

/// A link and the thread that serves it.
#[derive(Debug)]
pub struct Session {
    controls: Controls,
    hands: Sender<Hand>,
    thread: Option<JoinHandle<Result<(), String>>>,
}

impl Session {
    /// Begins to serve the link. `options` say how, and who listens.
    ///
    /// # Errors
    /// If the system has no thread left.
    pub fn begin(
        uri: LinkUri,
        options: impl FnOnce() -> Options + Send + 'static,
    ) -> Result<Self, String> {
        let (station, controls) = Station::new();
        let (hands, asked) = channel();
        let host = Handled {
            station,
            asked,
            pushes: Vec::new(),
            lifts: true,
        };
        let thread = std::thread::Builder::new()
            .name("link".into())
            .spawn(move || {
                let (_, result) = drive(&uri, options(), host);
                result.map_err(|error: LinkError<OperatorError>| error.to_string())
            })
            .map_err(|error| format!("cannot begin a thread: {error}"))?;
        Ok(Self {
            controls,
            hands,
            thread: Some(thread),
        })
    }

    /// Asks something of the board.
    pub fn ask(&self, request: Request) {
        // A link that has ended is noticed by `is_over`.
        let _ = self.controls.send(request);
    }

    /// Does something to the simulated arm; nothing to a real one.
    pub fn handle(&self, hand: Hand) {
        let _ = self.hands.send(hand);
    }

    /// Whether the link is no longer served.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Disarms the board and waits until it has said so.
    ///
    /// # Errors
    /// If the link could not be served, or ended by itself: one sentence.
    pub fn end(mut self) -> Result<(), String> {
        self.leave()
    }

    fn leave(&mut self) -> Result<(), String> {
        self.ask(Request::Leave);
        let begun = Instant::now();
        while !self.is_over() {
            if begun.elapsed() > LEAVE {
                return Err(
                    "the link does not end; the board switches torque off when its host is \
                     silent: look whether the arm is limp"
                        .into(),
                );
            }
            std::thread::sleep(LOOK);
        }
        match self.thread.take().map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(result)) => result,
            Some(Err(_)) => Err("the link's thread ended by a mistake of this program".into()),
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Nobody is left to be told.
        let _ = self.leave();
    }
}

/// A station with hands at its side.
struct Handled {
    station: Station,
    asked: Receiver<Hand>,
    pushes: Vec<Push>,
    /// The arm is to be taken in hand; at first it is.
    lifts: bool,
}

impl Handled {
    fn look(&mut self) {
        for hand in self.asked.try_iter() {
            match hand {
                Hand::Lift => self.lifts = true,
                Hand::Push(joint) => self.pushes.push(Push {
                    joint,
                    torque_nm: PUSH_NM,
                    // At once.
                    start_ns: 0,
                    duration_ns: PUSH_NS,
                }),
            }
        }
    }
}

impl Host for Handled {
    type Error = OperatorError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], OperatorError> {
        self.station.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), OperatorError> {
        self.station.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.station.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.station.is_done()
    }

    fn parted(&mut self, now_us: u64) {
        self.station.parted(now_us);
    }

    fn lifts_arm(&mut self) -> bool {
        self.look();
        std::mem::take(&mut self.lifts)
    }

    fn take_pushes(&mut self) -> Vec<Push> {
        self.look();
        std::mem::take(&mut self.pushes)
    }
}
