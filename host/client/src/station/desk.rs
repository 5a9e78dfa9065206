//! What a host works through: requests in order, an emergency stop before all of them,
//! and leaving.
//!
//! Clockless and without a thread: told what the time is, it says what to send.

use std::collections::VecDeque;

use armbridge_shared::link::message::{
    BoardReport, Command, Mode, Refusal, Settings, ToBoard, ToHost,
};

use super::Request;
use crate::error::OperatorError;
use crate::link::{Client, Said};

/// How long a board may take to answer the first hello.
const HELLO_TIMEOUT_US: u64 = 3_000_000;
/// How long an emergency stop is repeated until a fault is heard of.
const STOP_TIMEOUT_US: u64 = 1_000_000;
/// Between two of them.
const STOP_AGAIN_US: u64 = 20_000;
/// How long the board may take to say that it has disarmed, before we leave without.
const LEAVE_TIMEOUT_US: u64 = 1_000_000;
/// More than anybody asks for in one go; what is more comes from somebody who does not
/// look at what becomes of it.
const QUEUE_MAX: usize = 64;

/// How far the way out has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Leaving {
    /// Nobody wants to.
    #[default]
    No,
    /// The board is told to disarm, and given up on at this time.
    Disarming(u64),
    /// Goodbye is the next word.
    Goodbye,
    /// It has been said.
    Gone,
}

/// One end of a link, with what is still to be said.
#[derive(Debug, Default)]
pub struct Desk {
    client: Client,
    queue: VecDeque<Request>,
    report: Option<BoardReport>,
    settings: Option<Settings>,
    mode: Option<Mode>,
    /// The board answered at least once.
    was_greeted: bool,
    /// The command at hand is [`Request::Arm`], and whether it was tried before.
    arming: Option<bool>,
    /// Until when to say stop, and when next.
    stopping: Option<(u64, u64)>,
    leaving: Leaving,
    answer: Option<Result<(), Refusal>>,
}

impl Desk {
    /// What the board said to the latest request, once.
    pub fn take_answer(&mut self) -> Option<Result<(), Refusal>> {
        self.answer.take()
    }

    /// The board has answered our hello, and speaks our language.
    pub fn is_greeted(&self) -> bool {
        self.client.is_greeted()
    }

    /// What the board said of itself last.
    pub fn report(&self) -> Option<BoardReport> {
        self.report
    }

    /// What the board computes with, as it said last.
    pub fn settings(&self) -> Option<Settings> {
        self.settings
    }

    /// What the board was doing in its last record.
    pub fn mode(&self) -> Option<Mode> {
        self.mode
    }

    /// Everything asked for has been answered.
    pub fn is_settled(&self) -> bool {
        self.queue.is_empty() && self.client.is_settled() && self.stopping.is_none()
    }

    /// Takes a request. Whatever switches off comes before what waits.
    pub fn ask(&mut self, now_us: u64, request: Request) {
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
            Request::Command(Command::Idle) => {
                self.queue.clear();
                self.command(Command::Idle);
            }
            Request::Command(_) | Request::Arm => {
                if self.queue.len() < QUEUE_MAX {
                    self.queue.push_back(request);
                }
            }
        }
    }

    fn command(&mut self, command: Command) {
        self.arming = None;
        self.answer = None;
        self.client.command(command);
    }

    fn leave(&mut self, now_us: u64) {
        self.queue.clear();
        self.leaving = match self.mode {
            // Whoever has the bus on the transparent port keeps it.
            Some(Mode::Passthrough) => Leaving::Gone,
            _ if !self.client.is_greeted() => Leaving::Goodbye,
            Some(_) | None => {
                self.command(Command::Idle);
                Leaving::Disarming(now_us + LEAVE_TIMEOUT_US)
            }
        };
    }

    /// Bytes for the board.
    ///
    /// # Errors
    /// If nobody is there.
    pub fn transmit(&mut self, now_us: u64) -> Result<&[u8], OperatorError> {
        if let Leaving::Disarming(until_us) = self.leaving
            && now_us >= until_us
        {
            self.leaving = Leaving::Goodbye;
        }
        match self.leaving {
            Leaving::Goodbye => {
                self.leaving = Leaving::Gone;
                return Ok(self.client.farewell());
            }
            Leaving::Gone => return Ok(&[]),
            Leaving::No | Leaving::Disarming(_) => {}
        }
        if !self.was_greeted && now_us > HELLO_TIMEOUT_US {
            let damaged = self.client.stats().damaged;
            return Err(OperatorError::NoBoard { damaged });
        }
        self.stop_again(now_us);
        self.next();
        Ok(self.client.transmit(now_us))
    }

    fn stop_again(&mut self, now_us: u64) {
        let Some((until_us, next_us)) = self.stopping else {
            return;
        };
        if now_us >= until_us {
            self.stopping = None;
        } else if now_us >= next_us {
            self.client.say(ToBoard::Stop);
            self.stopping = Some((until_us, now_us + STOP_AGAIN_US));
        }
    }

    /// Goes on to the next request, if the one before is answered.
    fn next(&mut self) {
        if !self.client.is_greeted() || !self.client.is_settled() || self.stopping.is_some() {
            return;
        }
        match (self.queue.front(), self.report) {
            (Some(Request::Command(command)), _) => {
                let command = *command;
                self.queue.pop_front();
                self.command(command);
            }
            (Some(Request::Arm), Some(report)) => {
                self.queue.pop_front();
                self.arm(report, false);
            }
            // The report follows the hello.
            (Some(Request::Arm), None) | (None, _) => {}
            // Never in the queue.
            (Some(Request::Stop | Request::Leave), _) => {
                self.queue.pop_front();
            }
        }
    }

    fn arm(&mut self, report: BoardReport, is_retry: bool) {
        let session = report.session;
        self.command(Command::Arm { session });
        self.arming = Some(is_retry);
    }

    /// When to be asked again, at the latest.
    pub fn wake_at_us(&self) -> u64 {
        let stop_us = self.stopping.map_or(u64::MAX, |(_, next_us)| next_us);
        let leave_us = match self.leaving {
            Leaving::No => u64::MAX,
            Leaving::Disarming(until_us) => until_us,
            Leaving::Goodbye | Leaving::Gone => 0,
        };
        self.client.wake_at_us().min(stop_us).min(leave_us)
    }

    /// Takes bytes from the board, and hands on what they say.
    ///
    /// # Errors
    /// If the board was built from other message types.
    pub fn receive(
        &mut self,
        now_us: u64,
        bytes: &[u8],
        mut heard: impl FnMut(&Said),
    ) -> Result<(), OperatorError> {
        let mut all = Vec::new();
        self.client.receive(bytes, |said| all.push(said));
        for said in &all {
            self.take(now_us, said)?;
            heard(said);
        }
        Ok(())
    }

    fn take(&mut self, now_us: u64, said: &Said) -> Result<(), OperatorError> {
        match *said {
            Said::OtherSchema(hello) => return Err(OperatorError::OtherSchema(hello)),
            Said::Hello => self.was_greeted = true,
            Said::Done => self.answered(Ok(())),
            Said::Refused(Refusal::OtherSession) if self.arming == Some(false) => {
                if let Some(report) = self.report {
                    self.arm(report, true);
                }
            }
            Said::Refused(refusal) => self.answered(Err(refusal)),
            Said::Told(ToHost::Board(report)) => {
                let before = self.report.replace(report);
                if before.is_some_and(|before| before.is_before_reset(&report)) {
                    // Meant for the board before.
                    self.forget(now_us);
                }
            }
            Said::Told(ToHost::Record(record)) => {
                self.mode = Some(record.mode);
                if matches!(record.mode, Mode::Fault(_)) {
                    self.stopping = None;
                }
            }
            Said::Told(ToHost::Settings(settings)) => self.settings = Some(settings),
            Said::Told(ToHost::Passthrough) => self.mode = Some(Mode::Passthrough),
            Said::Told(
                ToHost::Hello(_)
                | ToHost::Ack { .. }
                | ToHost::Departs { .. }
                | ToHost::Began(_)
                | ToHost::Absent { .. }
                | ToHost::Found { .. }
                | ToHost::Mixed(_)
                | ToHost::Unprepared { .. }
                | ToHost::Port(_)
                | ToHost::Tripped(_)
                | ToHost::Off(_)
                | ToHost::Concluded(_)
                | ToHost::Temperature { .. },
            ) => {}
        }
        Ok(())
    }

    fn answered(&mut self, answer: Result<(), Refusal>) {
        self.arming = None;
        self.answer = Some(answer);
        if let Leaving::Disarming(_) = self.leaving {
            self.leaving = Leaving::Goodbye;
        }
    }

    /// What was asked for is for nobody any more; who wanted to leave can.
    fn forget(&mut self, now_us: u64) {
        self.queue.clear();
        self.arming = None;
        self.stopping = None;
        if let Leaving::Disarming(_) = self.leaving {
            self.leave(now_us);
        }
    }

    /// The connection broke: nothing is asked for any more.
    pub fn parted(&mut self, _now_us: u64) {
        self.client.parted();
        self.report = None;
        self.settings = None;
        self.mode = None;
        self.queue.clear();
        self.arming = None;
        self.stopping = None;
        self.leaving = match self.leaving {
            Leaving::No => Leaving::No,
            // Nobody hears a goodbye: the board's own guard acts.
            Leaving::Disarming(_) | Leaving::Goodbye | Leaving::Gone => Leaving::Gone,
        };
    }

    /// Nothing is left to say.
    pub fn is_done(&self) -> bool {
        self.leaving == Leaving::Gone
    }
}
