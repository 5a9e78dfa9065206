//! Session with a board: requests in order, arming, the emergency stop, and the end.
//!
//! Sans-io and clockless, like the board's end: the same [`Session`] runs in virtual time
//! and over a byte stream in wall-clock time. It never arms by itself: requests from
//! before the link broke or the board was reset are dropped.
//!
//! ```text
//! requests --> Session --> CommandLink --bytes--> board
//!                 |             ^
//!            BoardStatus        `------bytes----- board
//! ```
//!
//! | module           | contents                                                    |
//! |------------------|-------------------------------------------------------------|
//! | [`command_link`] | hello, heartbeats, one command until it is acknowledged     |
//! | `leaving`        | the end: the park, and the goodbye                           |
//! | [`channel_host`] | a host that takes its requests from a channel, on its own thread |
//!
//! # Times
//!
//! Each timeout of the hosts in this workspace is one of the constants below; the
//! board's own are `Limits` in `armbridge_link`.

pub mod channel_host;
pub mod command_link;
mod leaving;

pub use channel_host::{ChannelHost, PendingAnswer, RequestError, SessionEnded, SessionHandle};
pub use command_link::{BoardMessage, CommandLink, LinkStats};

use std::collections::VecDeque;

use armbridge_board::bridge::limits::PARK_US;
use armbridge_link::message::{BoardReport, Command, Mode, Refusal, ToBoard, ToHost};
use armbridge_link::server::LinkRole;

use crate::error::SessionError;
use crate::status::BoardStatus;
use leaving::Leaving;

/// Timeout of the first hello.
pub const HELLO_TIMEOUT_US: u64 = 3_000_000;
/// Timeout of a command's acknowledgement, and of the records of an armed board, which
/// sends one every tick.
pub const ANSWER_TIMEOUT_US: u64 = 2_000_000;
/// Timeout of arming: the board learns the noise of the encoders before, which takes 48 ticks
/// of an arm at rest, and up to 10 s at the longest period.
pub const ARM_TIMEOUT_US: u64 = 11_000_000;
/// Timeout of the servo search: bring-up takes 30 ms, at several rates longer.
pub const SERVO_TIMEOUT_US: u64 = 3_000_000;
/// Longest time for which an emergency stop is repeated; a reported fault ends it.
const STOP_TIMEOUT_US: u64 = 1_000_000;
/// Interval of these repetitions.
const STOP_INTERVAL_US: u64 = 20_000;
/// Timeout of the acknowledgement of disarming; the session
/// ends without it.
const LEAVE_TIMEOUT_US: u64 = 1_000_000;
/// Longest time in µs that a board takes to park the arm, and a second.
pub const PARK_TIMEOUT_US: u64 = PARK_US + 1_000_000;
/// Capacity of the queue of requests; further ones, from a program that ignores the
/// replies, are dropped.
const QUEUE_MAX: usize = 64;
/// Attempts to arm while the board counts up its sessions, one for each hello that it
/// receives.
const ARM_ATTEMPTS: u32 = 3;

/// Request to a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// Repeat this command until the board answers.
    Command(Command),
    /// Arm, with the session number that the board has reported.
    Arm,
    /// Emergency stop, at once.
    Stop,
    /// Park the arm or disarm, send a goodbye when that is done, and end.
    Leave,
}

/// The host's end of a link, with its requests and the board's status.
#[derive(Debug, Default)]
pub struct Session {
    link: CommandLink,
    /// Requests to come, with their numbers.
    queue: VecDeque<(u64, Request)>,
    /// Number of requests so far, and that of the one that was begun last.
    requested: u64,
    begun: u64,
    status: BoardStatus,
    /// The board answered at least once.
    was_greeted: bool,
    /// Time since when the first answer on this connection is awaited.
    waiting_since_us: Option<u64>,
    /// Attempts to arm so far.
    arm_attempts: u32,
    /// End of the repeated stop, and time of the next one.
    stopping: Option<(u64, u64)>,
    leaving: Leaving,
    answer: Option<Result<(), Refusal>>,
}

impl Session {
    /// The result of the request that was [begun](Self::begun) last, once.
    pub fn take_answer(&mut self) -> Option<Result<(), Refusal>> {
        self.answer.take()
    }

    /// Number of the request that was begun last. Those before it have been answered, or dropped.
    pub fn begun(&self) -> u64 {
        self.begun
    }

    /// Whether the board has answered the hello, with the schema of this program.
    pub fn is_greeted(&self) -> bool {
        self.link.is_greeted()
    }

    /// The board's status.
    pub fn status(&self) -> &BoardStatus {
        &self.status
    }

    /// Counts of the link's frames.
    pub fn stats(&self) -> LinkStats {
        self.link.stats()
    }

    /// Whether all requests are answered.
    pub fn is_settled(&self) -> bool {
        self.queue.is_empty() && self.link.is_settled() && self.stopping.is_none()
    }

    /// Queues a request, and returns its number. One that ends the drive of the motors overtakes
    /// the queued ones, which are dropped.
    pub fn request(&mut self, now_us: u64, request: Request) -> u64 {
        self.requested += 1;
        match request {
            Request::Stop => {
                self.queue.clear();
                self.stopping = Some((now_us + STOP_TIMEOUT_US, now_us));
            }
            Request::Leave => {
                if self.leaving == Leaving::No {
                    self.leave(now_us);
                }
            }
            Request::Command(command @ (Command::Idle | Command::Park)) => {
                self.queue.clear();
                self.begun = self.requested;
                self.command(command);
            }
            Request::Command(_) | Request::Arm => {
                if self.queue.len() < QUEUE_MAX {
                    self.queue.push_back((self.requested, request));
                }
            }
        }
        self.requested
    }

    fn command(&mut self, command: Command) {
        self.arm_attempts = 0;
        self.answer = None;
        self.link.command(command);
    }

    fn leave(&mut self, now_us: u64) {
        self.queue.clear();
        self.leaving = match self.status.mode() {
            // The client of the transparent port keeps the bus.
            Some(Mode::Passthrough) => Leaving::Gone,
            _ if !self.link.is_greeted() || self.status.is_observer() => Leaving::Goodbye,
            Some(_) | None => {
                self.begun = self.requested;
                self.command(Command::Park);
                Leaving::begin(now_us)
            }
        };
    }

    /// Bytes for the board.
    ///
    /// # Errors
    /// If no board has answered the first hello in 3 s.
    pub fn transmit(&mut self, now_us: u64) -> Result<&[u8], SessionError> {
        if self.leaving.advance(now_us) {
            return Ok(self.link.goodbye());
        }
        if self.is_done() {
            return Ok(&[]);
        }
        let since_us = *self.waiting_since_us.get_or_insert(now_us);
        if !self.was_greeted && now_us - since_us > HELLO_TIMEOUT_US {
            let damaged = self.link.stats().damaged;
            return Err(SessionError::NoBoard { damaged });
        }
        self.repeat_stop(now_us);
        self.start_next();
        Ok(self.link.transmit(now_us))
    }

    fn repeat_stop(&mut self, now_us: u64) {
        let Some((until_us, next_us)) = self.stopping else {
            return;
        };
        if now_us >= until_us {
            self.stopping = None;
        } else if now_us >= next_us {
            self.link.send(ToBoard::Stop);
            self.stopping = Some((until_us, now_us + STOP_INTERVAL_US));
        }
    }

    fn can_send(&self) -> bool {
        self.link.is_greeted() && self.link.is_settled() && self.stopping.is_none()
    }

    /// Starts the next request, if the one before is answered.
    fn start_next(&mut self) {
        if !self.can_send() {
            return;
        }
        let Some((number, request)) = self.queue.front().copied() else {
            return;
        };
        match (request, self.status.report) {
            (Request::Command(command), _) => self.command(command),
            (Request::Arm, Some(report)) => self.arm(report, 1),
            // The report follows the hello.
            (Request::Arm, None) => return,
            // Never in the queue.
            (Request::Stop | Request::Leave, _) => {}
        }
        self.begun = number;
        self.queue.pop_front();
    }

    fn arm(&mut self, report: BoardReport, attempt: u32) {
        let session = report.session;
        self.command(Command::Arm { session });
        self.arm_attempts = attempt;
    }

    /// Latest time of the next call of [`transmit`](Session::transmit).
    pub fn wake_at_us(&self) -> u64 {
        let stop_us = self.stopping.map_or(u64::MAX, |(_, next_us)| next_us);
        let queue_us = match self.queue.front() {
            Some(_) if self.can_send() => 0,
            Some(_) | None => u64::MAX,
        };
        let wake_us = self.link.wake_at_us().min(queue_us);
        wake_us.min(stop_us).min(self.leaving.wake_at_us())
    }

    /// Decodes bytes from the board, up to the end of a message, which is in the
    /// [`status`](Session::status) afterwards; the rest stays in `bytes`. `None` at their
    /// end.
    ///
    /// # Errors
    /// If the board was built from other message types.
    pub fn receive(
        &mut self,
        now_us: u64,
        bytes: &mut &[u8],
    ) -> Result<Option<BoardMessage>, SessionError> {
        while let Some(message) = self.link.receive(bytes) {
            if self.take(now_us, &message)? {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// Processes all of these bytes.
    ///
    /// # Errors
    /// As [`receive`](Session::receive).
    pub(crate) fn receive_all(
        &mut self,
        now_us: u64,
        mut bytes: &[u8],
    ) -> Result<(), SessionError> {
        while self.receive(now_us, &mut bytes)?.is_some() {}
        Ok(())
    }

    /// Processes a message. False if it concerns only the session.
    fn take(&mut self, now_us: u64, message: &BoardMessage) -> Result<bool, SessionError> {
        match message {
            BoardMessage::OtherSchema(hello) => {
                self.status.take(&ToHost::Hello(*hello));
                return Err(SessionError::OtherSchema(*hello));
            }
            BoardMessage::Hello(hello) => {
                self.was_greeted = true;
                self.status.take(&ToHost::Hello(*hello));
            }
            BoardMessage::Done => self.finish_request(now_us, Ok(())),
            BoardMessage::Refused(Refusal::OtherSession)
                if (1..ARM_ATTEMPTS).contains(&self.arm_attempts) =>
            {
                if let Some(report) = self.status.report {
                    self.arm(report, self.arm_attempts + 1);
                    return Ok(false);
                }
            }
            BoardMessage::Refused(refusal) => self.finish_request(now_us, Err(*refusal)),
            BoardMessage::Other(message) => {
                let before = self.status.report;
                self.status.take(message);
                match message {
                    ToHost::Board(report)
                        if before.is_some_and(|before| before.is_before_reset(report)) =>
                    {
                        // Intended for the board before its reset.
                        self.drop_requests(now_us);
                    }
                    ToHost::Record(record) if matches!(record.mode, Mode::Fault(_)) => {
                        self.stopping = None;
                    }
                    _ => {}
                }
                if !self.status.is_driven() {
                    self.leaving.switched_off();
                }
            }
        }
        Ok(true)
    }

    fn finish_request(&mut self, now_us: u64, answer: Result<(), Refusal>) {
        self.arm_attempts = 0;
        self.answer = Some(answer);
        let parks = self.status.has_pose() && answer.is_ok() && self.status.is_driven();
        self.leaving.answered(now_us, parks);
    }

    /// Drops the requests; an ongoing end of the session continues.
    fn drop_requests(&mut self, now_us: u64) {
        self.queue.clear();
        self.arm_attempts = 0;
        self.stopping = None;
        if let Leaving::Disarming(_) = self.leaving {
            self.leave(now_us);
        }
    }

    /// Takes this program's role on a served link.
    pub fn set_role(&mut self, role: LinkRole) {
        self.status.role = Some(role);
    }

    /// Drops requests and status after the connection broke.
    pub fn disconnected(&mut self) {
        self.link.disconnected();
        self.waiting_since_us = None;
        self.status.forget();
        self.queue.clear();
        self.arm_attempts = 0;
        self.stopping = None;
        self.leaving.disconnected();
    }

    /// Whether the session has ended.
    pub fn is_done(&self) -> bool {
        self.leaving == Leaving::Gone
    }
}
