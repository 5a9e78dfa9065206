//! Motor check: direction and joint of each motor, tested before a controller closes the loop.
//!
//! A motor that turns the other way than its encoder counts makes a controller throw the arm
//! over; so may servos that are swapped. Neither shows while torque is off. So the first arming
//! gives both joints a known torque, beside the model's gravity, and compares their motion with
//! the model's:
//!
//! ```text
//! torque  +T   __      __    ____    __      T: the inertia times `limits.check_rad_s2`
//!          0 _|  |    |  |  |    |  |  |_
//!         -T     |____|  |__|    |__|        pulses of 30 ms: three counts either way
//! ```
//!
//! Mass matrix and viscous friction are diagonal, so that both joints are tested at once. At
//! 1 kHz a check takes 260 ms; at longer periods the [pulses](pattern) are repeated until there
//! are enough samples. A joint that does not move, and joints that look swapped, are tested a
//! second time before that is a fault. Beyond [`CHECK_PERIOD_MAX_US`] the arm would fall
//! meanwhile: the board refuses to arm until a check at a shorter period, or
//! `limits.check_rad_s2` 0.
//!
//! Where the limits of the host leave too little torque to move a joint, or to tell the joints
//! apart, the arm is armed, and checked again at the next arming, until a check is conclusive:
//! the limits may have been raised by then.
//!
//! # Swapped servos
//!
//! Motor and encoder of a servo are in one housing, so that swapped servos turn the right
//! way. But each then moves the inertia of the other joint: the ratio of both
//! [responses](response), 1 on the arm of the model, is `(M1 / M2)^2`, which is 1.7 on the
//! paper's. Supply and friction, nearly the same for both, leave the ratio as it is. Joints
//! whose inertias are too alike ([`SWAP_RATIO_MIN`]) are not told apart; an arm that is not the
//! model may look swapped, and is armed with `limits.check_rad_s2` 0.
//!
//! # Bound
//!
//! A joint that moves by [`ABORT_RAD`] ends the check: neither a wrong motor nor an arm that
//! falls goes further before torque is off.
//!
//! [`CHECK_PERIOD_MAX_US`]: super::limits::CHECK_PERIOD_MAX_US

mod pattern;
mod response;

use armbridge_control::arm::{Parameters, Posture};
use armbridge_link::message::Fault;
use armbridge_link::record::Violation;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;
use pattern::Pattern;
use response::{CONCLUSIVE_NM, Response};

/// Torque of the second attempt, as a multiple of the first's: static friction may have held a
/// joint.
const STRONGER: f32 = 1.6;

/// Response of a joint that moves, and, with the other sign, of one whose motor turns the wrong
/// way.
const MOVED: f32 = 0.35;

/// Motion in rad that ends the check.
const ABORT_RAD: f32 = 0.06;

/// Least ratio of responses, by the model, at which swapped servos are detected.
const SWAP_RATIO_MIN: f32 = 1.5;

/// State of the check.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct MotorCheck {
    /// Factor of the torque in the second attempt; `None` in the first.
    repeated: Option<f32>,
    /// Ticks since the beginning of the attempt.
    tick: u32,
    /// Angles at the beginning of the check, in rad.
    start_rad: Option<Vector2<f32>>,
    /// Gravity torque in N m in the command that is to be sent next.
    gravity_nm: Vector2<f32>,
    /// Torque in N m beside gravity that acted until the present samples.
    acted_nm: Vector2<f32>,
    responses: [Response; JOINTS],
}

/// Inputs of the check in one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct CheckInput<'a> {
    pub(super) arm: &'a Parameters<f32>,
    /// Acceleration by the model, in rad/s².
    pub(super) acceleration_rad_s2: f32,
    pub(super) period_us: u32,
    /// Variance of each encoder's noise, in rad².
    pub(super) noise_rad2: [f32; JOINTS],
    /// Samples, in rad.
    pub(super) measured_rad: [Option<f32>; JOINTS],
    /// Estimated angles, in rad.
    pub(super) angle_rad: Vector2<f32>,
    /// Torque of the command in force, in N m.
    pub(super) in_force_nm: Vector2<f32>,
}

/// Result of a tick.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum CheckStep {
    /// The check goes on with this torque in N m.
    Torque(Vector2<f32>),
    /// Both motors turn their own joint the right way.
    Passed,
    /// They do not.
    Failed(Violation),
}

impl CheckStep {
    /// Torque in N m for the next tick; `None` at the end.
    pub(super) fn torque_nm(self) -> Option<Vector2<f32>> {
        match self {
            Self::Torque(torque_nm) => Some(torque_nm),
            Self::Passed | Self::Failed(_) => None,
        }
    }
}

/// Outcome of an attempt.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
enum Outcome {
    Step(CheckStep),
    /// A second attempt follows, with this multiple of the torque.
    Repeat {
        factor: f32,
    },
}

impl Outcome {
    fn failed(violation: Violation) -> Self {
        Self::Step(CheckStep::Failed(violation))
    }
}

impl MotorCheck {
    /// Runs a tick.
    pub(super) fn tick(&mut self, input: &CheckInput<'_>) -> CheckStep {
        let pattern = Pattern::new(input.period_us);
        let posture = Posture::of(input.angle_rad);
        let mass = posture.mass_diagonal(input.arm);
        let viscous = [input.arm.b1, input.arm.b2];
        let period_s = input.period_us as f32 * 1e-6;
        let share = self.tick as f32 / pattern.ticks as f32;
        let start_rad = *self.start_rad.get_or_insert(input.angle_rad);
        let mut is_far = None;
        for (i, response) in self.responses.iter_mut().enumerate() {
            response.advance(self.acted_nm[i], mass[i], viscous[i], period_s);
            if let Some(measured) = input.measured_rad[i] {
                response.take(measured, share, input.noise_rad2[i]);
            }
            let moved_rad = (input.angle_rad[i] - start_rad[i]).abs();
            if moved_rad > ABORT_RAD {
                is_far = Some((i, moved_rad));
            }
        }
        self.acted_nm = input.in_force_nm - self.gravity_nm;
        if self.tick == 0 {
            self.acted_nm = Vector2::zeros();
        }
        if let Some((joint, moved_rad)) = is_far {
            return self.far(joint, moved_rad, mass, input.arm.joints());
        }
        if self.tick == pattern.ticks {
            match self.conclude(mass, input.arm.joints()) {
                Outcome::Step(step) => return step,
                Outcome::Repeat { factor } => {
                    *self = Self {
                        repeated: Some(factor),
                        start_rad: self.start_rad,
                        ..Self::default()
                    };
                }
            }
        }
        let torque_nm = mass * (input.acceleration_rad_s2 * self.repeated.unwrap_or(1.0));
        self.gravity_nm = posture.gravity(input.arm);
        let sign = pattern.sign(self.tick);
        self.tick += 1;
        CheckStep::Torque(self.gravity_nm + torque_nm * sign)
    }

    /// Whether the check has moved each of the arm's joints, by enough torque to tell them apart.
    pub(super) fn is_conclusive(&self, joints: usize) -> bool {
        let mut responses = self.responses.iter().take(joints);
        responses.all(|response| response.is_conclusive() && response.ratio() > MOVED)
    }

    /// The outcome of an attempt: a joint that does not move, or joints that look swapped, are
    /// tested twice.
    fn conclude(&self, mass: Vector2<f32>, joints: usize) -> Outcome {
        let ratios = self.responses.each_ref().map(Response::ratio);
        let is_first = self.repeated.is_none();
        for (joint, ratio) in (0..).zip(ratios).take(joints) {
            if ratio < -MOVED {
                return Outcome::failed(Violation {
                    fault: Fault::MotorDirection,
                    joint: Some(joint),
                    value: ratio,
                    limit: MOVED,
                });
            }
        }
        for ((joint, ratio), response) in (0..).zip(ratios).zip(&self.responses).take(joints) {
            // NaN is no motion.
            let has_moved = ratio > MOVED;
            if !has_moved && is_first {
                return Outcome::Repeat { factor: STRONGER };
            }
            if !has_moved && response.is_conclusive() {
                let fault = if response.is_disturbed() {
                    Fault::ExternalTorque
                } else {
                    Fault::Stuck
                };
                return Outcome::failed(Violation {
                    fault,
                    joint: Some(joint),
                    value: response.largest_nm,
                    limit: CONCLUSIVE_NM,
                });
            }
        }
        let [first, second] = ratios;
        match self.assignment(ratios, mass, joints) {
            Assignment::Unclear | Assignment::Swapped if is_first => {
                Outcome::Repeat { factor: 1.0 }
            }
            Assignment::Unclear | Assignment::Right => Outcome::Step(CheckStep::Passed),
            Assignment::Swapped => Outcome::failed(Violation {
                value: first / second,
                limit: 1.0,
                ..Violation::plain(Fault::JointsSwapped)
            }),
        }
    }

    /// Which joints the servos move, if the torque was enough to tell.
    fn assignment(
        &self,
        [first, second]: [f32; JOINTS],
        mass: Vector2<f32>,
        joints: usize,
    ) -> Assignment {
        if joints == JOINTS && self.responses.iter().all(Response::is_conclusive) {
            assignment(first, second, mass)
        } else {
            Assignment::Right
        }
    }

    /// The outcome of a joint that has moved too far: what the samples until then show.
    fn far(&self, joint: usize, moved_rad: f32, mass: Vector2<f32>, joints: usize) -> CheckStep {
        let ratios = self.responses.each_ref().map(Response::ratio);
        let fault = if self.responses.iter().any(|it| it.direction() < -MOVED) {
            Fault::MotorDirection
        } else if ratios.iter().take(joints).all(|ratio| *ratio > MOVED) {
            match self.assignment(ratios, mass, joints) {
                Assignment::Right => return CheckStep::Passed,
                Assignment::Unclear => Fault::ExternalTorque,
                Assignment::Swapped => Fault::JointsSwapped,
            }
        } else {
            Fault::ExternalTorque
        };
        CheckStep::Failed(Violation {
            fault,
            joint: Some(joint as u8),
            value: moved_rad,
            limit: ABORT_RAD,
        })
    }
}

/// Which joints the servos move, by their responses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Assignment {
    Right,
    Unclear,
    Swapped,
}

/// Assignment by the ratio of the responses: 1 if it is right, `expected` if the servos are
/// swapped. On a logarithmic scale, the first half counts as right, and from three quarters on as
/// swapped, because friction raises the ratio; far beyond `expected` the arm is another than
/// the model.
fn assignment(first: f32, second: f32, mass: Vector2<f32>) -> Assignment {
    let expected = (mass.x / mass.y) * (mass.x / mass.y);
    let (ratio, expected) = if expected >= 1.0 {
        (first / second, expected)
    } else {
        (second / first, 1.0 / expected)
    };
    let squared = ratio * ratio;
    if expected < SWAP_RATIO_MIN || squared < expected || ratio > expected * expected {
        Assignment::Right
    } else if squared * squared < expected * expected * expected {
        Assignment::Unclear
    } else {
        Assignment::Swapped
    }
}

#[cfg(test)]
mod tests;
