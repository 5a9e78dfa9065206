//! Motors off: the board disarmed, stopped, or its fault cleared.

use armbridge_client::session::{ANSWER_TIMEOUT_US, Request, SERVO_TIMEOUT_US, Session};
use armbridge_client::status::BoardStatus;
use armbridge_client::transport::Intent;
use armbridge_link::message::{Command, Fault, Mode, Refusal};

use super::{Task, TaskError, View};

/// State that the board is brought to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// Disarmed.
    Disarm,
    /// Emergency stop: requested at once, before the hello is answered, and until the
    /// board reports it.
    Stop,
    /// No fault latched, and the servos found again.
    Clear,
}

impl Goal {
    /// Request that leads to it; `None` while the board cannot take it.
    fn request(self, session: &Session) -> Option<Request> {
        match self {
            Self::Disarm => session
                .is_greeted()
                .then_some(Request::Command(Command::Idle)),
            Self::Stop => Some(Request::Stop),
            Self::Clear => matches!(session.status().mode(), Some(Mode::Fault(_)))
                .then_some(Request::Command(Command::ClearFault)),
        }
    }

    fn is_reached(self, status: &BoardStatus, answer: Option<Result<(), Refusal>>) -> bool {
        match self {
            Self::Disarm => answer == Some(Ok(())),
            Self::Stop => status.trip.is_some(),
            Self::Clear => matches!(status.mode(), Some(Mode::Idle | Mode::Passthrough)),
        }
    }

    fn refused(self, refusal: Refusal) -> TaskError {
        let result = match self {
            Self::Disarm | Self::Stop => "the board does not disarm",
            Self::Clear => "the fault is not cleared",
        };
        TaskError::Refused { result, refusal }
    }

    fn timed_out(self, status: &BoardStatus) -> TaskError {
        match (self, status.trip) {
            (Self::Disarm, _) => TaskError::NotDisarmed,
            (Self::Stop, _) => TaskError::NotStopped,
            (Self::Clear, Some(trip)) => TaskError::FaultAgain(trip),
            (Self::Clear, None) => TaskError::ClearedOnly(status.obstacle),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Waiting,
    /// At this time.
    Requested(u64),
    Over,
}

/// Brings the board to its goal, then leaves.
#[derive(Debug)]
pub struct MotorsOff {
    goal: Goal,
    step: Step,
    cleared: Option<Fault>,
}

impl MotorsOff {
    /// Nothing requested yet.
    pub fn new(goal: Goal) -> Self {
        Self {
            goal,
            step: Step::Waiting,
            cleared: None,
        }
    }

    /// The fault that the board was asked to clear.
    pub fn cleared(&self) -> Option<Fault> {
        self.cleared
    }
}

impl Task for MotorsOff {
    fn look(&mut self, view: View<'_>) -> Result<(), TaskError> {
        let View { now_us, session } = view;
        if self.step == Step::Waiting
            && let Some(request) = self.goal.request(session)
        {
            if let (Goal::Clear, Some(Mode::Fault(fault))) = (self.goal, session.status().mode()) {
                self.cleared = Some(fault);
            }
            session.request(now_us, request);
            self.step = Step::Requested(now_us);
            return Ok(());
        }
        let (since_us, timeout_us) = match (self.step, self.goal) {
            // The session limits the time until the hello is answered.
            (Step::Over, _) | (Step::Waiting, Goal::Disarm | Goal::Stop) => return Ok(()),
            (Step::Waiting, Goal::Clear) => (0, 2 * SERVO_TIMEOUT_US),
            (Step::Requested(since_us), Goal::Clear) => (since_us, SERVO_TIMEOUT_US),
            (Step::Requested(since_us), Goal::Disarm | Goal::Stop) => (since_us, ANSWER_TIMEOUT_US),
        };
        let answer = session.take_answer();
        if self.goal.is_reached(session.status(), answer) {
            self.step = Step::Over;
            session.request(now_us, Request::Leave);
            return Ok(());
        }
        match answer {
            // The board soon reports that motors are off, or that they are not.
            Some(Err(Refusal::NotOff)) if self.goal == Goal::Clear => self.step = Step::Waiting,
            // A stop goes on until the board reports it, whatever else is answered.
            Some(Err(refusal)) if self.goal != Goal::Stop => {
                return Err(self.goal.refused(refusal));
            }
            Some(_) | None => {}
        }
        if now_us.saturating_sub(since_us) > timeout_us {
            return Err(self.goal.timed_out(session.status()));
        }
        Ok(())
    }

    fn intent(&self) -> Intent {
        match self.goal {
            Goal::Disarm | Goal::Clear => Intent::Command,
            // Any program may stop.
            Goal::Stop => Intent::CommandOrObserve,
        }
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.step = Step::Waiting;
    }
}
