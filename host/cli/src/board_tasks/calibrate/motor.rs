//! One gentle push, to see that a motor turns the way its encoder counts.
//!
//! The push needs no model of the arm. The board's own check at the first arming does, and is
//! left out meanwhile (`limits.check_rad_s2` 0).

use armbridge_client::fault_text;
use armbridge_client::session::{Request, SERVO_TIMEOUT_US};
use armbridge_control::actuator::{Direction, Joint};
use armbridge_link::message::{Command, Limits, Mode, Trip};
use armbridge_servo::JOINTS;

use super::Guide;
use crate::board_tasks::{TaskError, View};

/// PWM counts of the push: a tenth of full duty, and so of the stall torque; of an AX-12A 0.12 N m,
/// twice the static friction.
const PUSH_COUNTS: f32 = 100.0;
/// Duration of the push in µs.
const PUSH_US: u64 = 300_000;
/// Angle that it must have moved by, in rad: eight counts of an AX-12A.
const MOVED_MIN_RAD: f32 = 0.041;

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
    /// For servos that take torque.
    Preparing(u64),
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
    calibration: Joint<f32>,
    step: Step,
    moved: i32,
    /// Of the limits from before.
    check_rad_s2: u8,
}

impl Motor {
    /// Asks whether it may push, and set servos that are not ready to the mode that takes torque.
    pub(super) fn ask(
        joint: usize,
        calibration: Joint<f32>,
        is_ready: bool,
        guide: &mut impl Guide,
    ) -> Self {
        guide.say(&format!(
            "Joint {}: its motor will push with {:.2} N m for 0.3 s towards positive angles. \
             Let go of the arm and keep clear. {}Go on? [y/N]",
            joint + 1,
            PUSH_COUNTS / calibration.gain_counts_per_nm,
            if is_ready {
                ""
            } else {
                "Its servo is set to wheel mode (X servos: PWM control mode), which it keeps. "
            }
        ));
        Self {
            joint,
            calibration,
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
        let is_ready = status.servos.is_some_and(|servos| servos.is_ready);
        let obstacle = status.obstacle;
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
                if view.is_acknowledged(since_us, "the board refused the limits")? {
                    if !is_ready {
                        view.session
                            .request(now_us, Request::Command(Command::Prepare));
                    }
                    self.step = Step::Preparing(now_us);
                }
            }
            (Step::Preparing(_), _) if is_ready => {
                view.session.request(now_us, Request::Arm);
                self.step = Step::Arming(now_us);
            }
            (Step::Preparing(since_us), _) => {
                if now_us.saturating_sub(since_us) > SERVO_TIMEOUT_US {
                    return Err(TaskError::NoWheelMode(obstacle));
                }
            }
            (Step::Arming(since_us), Some(count)) => {
                if view.is_acknowledged(since_us, "the board refused the arming")? {
                    let mut torque_nm = [0.0; JOINTS];
                    torque_nm[self.joint] = PUSH_COUNTS / self.calibration.gain_counts_per_nm;
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
                if view.is_acknowledged(since_us, "the board refused the disarming")? {
                    self.limit(view, self.check_rad_s2);
                    self.step = Step::Restoring(now_us);
                }
            }
            (Step::Restoring(since_us), _) => {
                if view.is_acknowledged(since_us, "the board refused the limits")? {
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
        let turned_rad = self.moved as f32 * self.calibration.rad_per_count;
        let moved_rad = match self.calibration.direction {
            Direction::Forward => turned_rad,
            Direction::Reverse => -turned_rad,
        };
        if moved_rad >= MOVED_MIN_RAD {
            let counts = self.moved;
            guide.say(&format!(
                "Joint {joint}: it moved by {counts} counts, as it should."
            ));
            return Ok(());
        }
        if moved_rad <= -MOVED_MIN_RAD {
            return Err(MotorError::Reversed {
                joint,
                counts: self.moved,
            });
        }
        Err(MotorError::Still { joint })
    }
}
