//! One gentle push, to see that a motor turns the way its encoder counts.
//!
//! The push needs no model of the arm. The board's own check at the first arming does, and is
//! left out meanwhile (`limits.check_rad_s2` 0).

use armbridge_client::fault_text;
use armbridge_client::session::Request;
use armbridge_control::actuator::Direction;
use armbridge_link::message::{Command, Limits, Mode, Trip};
use armbridge_servo::JOINTS;

use super::{Guide, answer};
use crate::board_tasks::{TaskError, View};

/// Torque of the push in N m: twice the static friction, a tenth of the stall torque.
const PUSH_NM: f32 = 0.12;
/// Duration of the push in µs.
const PUSH_US: u64 = 300_000;
/// Counts that it must have moved by.
const MOVED_MIN: i32 = 8;

/// Why the check of a motor failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotorError {
    /// The board switched torque off meanwhile.
    #[error("the board switched off: {}", fault_text::in_words(.0).cause)]
    Fault(Trip),
    /// The question was answered with no.
    #[error("the check of the motor was declined")]
    Declined,
    /// It turns against its encoder.
    #[error(
        "joint {joint} moved by {counts} counts, the wrong way: its motor and its encoder \
         disagree; was it opened?"
    )]
    Reversed {
        /// From 1.
        joint: usize,
        /// Counts that it moved by.
        counts: i32,
    },
    /// It did not turn.
    #[error("joint {joint} did not move; is it blocked, or its supply off?")]
    Still {
        /// From 1.
        joint: usize,
    },
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Asking,
    /// For the limits without the board's own check.
    Limiting(u64),
    Arming(u64),
    /// From this count, until this time.
    Pushing(u16, u64),
    Stopping(u64),
    /// For the limits from before.
    Restoring(u64),
}

/// The check of one joint's motor.
#[derive(Debug)]
pub(super) struct Motor {
    joint: usize,
    direction: Direction,
    step: Step,
    moved: i32,
    /// Of the limits from before.
    check_rad_s2: u8,
}

impl Motor {
    /// Asks whether it may push.
    pub(super) fn ask(joint: usize, direction: Direction, guide: &mut impl Guide) -> Self {
        guide.say(&format!(
            "Joint {}: its motor will push with {PUSH_NM} N m for 0.3 s towards positive angles. \
             Let go of the arm and keep clear. Go on? [y/N]",
            joint + 1
        ));
        Self {
            joint,
            direction,
            step: Step::Asking,
            moved: 0,
            check_rad_s2: 0,
        }
    }

    /// Its joint, counting from 0.
    pub(super) fn joint(&self) -> usize {
        self.joint
    }

    /// True once the check has passed.
    pub(super) fn look(
        &mut self,
        view: &mut View<'_>,
        guide: &mut impl Guide,
    ) -> Result<bool, TaskError> {
        let status = view.session.status();
        if let (Some(Mode::Fault(_)), Some(tripped)) = (status.mode(), status.trip) {
            return Err(MotorError::Fault(tripped).into());
        }
        let now_us = view.now_us;
        let count = status
            .record
            .and_then(|record| record.input.samples[self.joint].counts());
        match (self.step, count) {
            (Step::Asking, _) => match guide.answer()?.as_deref().map(str::trim) {
                None => {}
                Some("y" | "Y" | "yes") => {
                    self.limit(view, 0);
                    self.step = Step::Limiting(now_us);
                }
                Some(_) => return Err(MotorError::Declined.into()),
            },
            (Step::Limiting(since_us), _) => {
                if answer(view, since_us, "the board refused the limits")? {
                    view.session.request(now_us, Request::Arm);
                    self.step = Step::Arming(now_us);
                }
            }
            (Step::Arming(since_us), Some(count)) => {
                if answer(view, since_us, "the board refused the arming")? {
                    let mut torque_nm = [0.0; JOINTS];
                    torque_nm[self.joint] = PUSH_NM;
                    let push = Command::Torque(torque_nm);
                    view.session.request(now_us, Request::Command(push));
                    self.step = Step::Pushing(count, now_us + PUSH_US);
                }
            }
            (Step::Pushing(from, until_us), Some(count)) if now_us >= until_us => {
                self.moved = i32::from(count) - i32::from(from);
                view.session
                    .request(now_us, Request::Command(Command::Idle));
                self.step = Step::Stopping(now_us);
            }
            (Step::Stopping(since_us), _) => {
                if answer(view, since_us, "the board refused the disarming")? {
                    self.limit(view, self.check_rad_s2);
                    self.step = Step::Restoring(now_us);
                }
            }
            (Step::Restoring(since_us), _) => {
                if answer(view, since_us, "the board refused the limits")? {
                    self.check(guide)?;
                    return Ok(true);
                }
            }
            // A sample is missing, or it is still pushing.
            (Step::Arming(_) | Step::Pushing(..), _) => {}
        }
        Ok(false)
    }

    /// Commands the present limits with another acceleration of the board's own check.
    fn limit(&mut self, view: &mut View<'_>, check_rad_s2: u8) {
        let settings = view.session.status().settings;
        let limits = settings.map_or_else(Limits::default, |settings| settings.limits);
        self.check_rad_s2 = limits.check_rad_s2;
        let limits = Limits {
            check_rad_s2,
            ..limits
        };
        view.session
            .request(view.now_us, Request::Command(Command::Limit(limits)));
    }

    fn check(&self, guide: &mut impl Guide) -> Result<(), MotorError> {
        let joint = self.joint + 1;
        let forward = match self.direction {
            Direction::Forward => self.moved,
            Direction::Reverse => -self.moved,
        };
        if forward >= MOVED_MIN {
            let counts = self.moved;
            guide.say(&format!(
                "Joint {joint}: it moved by {counts} counts, as it should."
            ));
            return Ok(());
        }
        if forward <= -MOVED_MIN {
            return Err(MotorError::Reversed {
                joint,
                counts: self.moved,
            });
        }
        Err(MotorError::Still { joint })
    }
}
