//! What every tick is held against, and what the torque is held to.
//!
//! ```text
//! samples, estimate -> judge -> control law -> shape -> PWM
//!                        |                       |
//!                        +------ Violation ------+--> torque off
//! ```
//!
//! [`Guard::judge`] doubts: it says when samples, estimate or arm are not what
//! they would be if all were well. [`Guard::shape`] prevents: it brakes a joint
//! before its angle limit and holds torque and its rate to their limits, and
//! doubts only when it has to go on doing so. The first violation wins: what
//! follows is often its consequence.
//!
//! Nothing here reads a clock, looks at a mode or switches anything: ticks are
//! counted, and what follows from a violation is the supervisor's.
//!
//! | module      | what                                                        |
//! |-------------|-------------------------------------------------------------|
//! | `losses`    | a servo is silent, samples are lost in a row or too often   |
//! | `samples`   | an encoder is in its gap, the samples leave the estimator   |
//! | `motion`    | a joint is beyond its angle or its speed                    |
//! | `stuck`     | a joint or its encoder does not move                        |
//! | `soft_stop` | bounds of the torque within which the arm stays inside      |
//! | `torque`    | torque within all limits; braked or limited for too long    |
//! | `ticks`     | times as numbers of ticks                                   |

mod losses;
mod motion;
mod samples;
mod soft_stop;
mod stuck;
#[cfg(test)]
mod tests;
mod ticks;
mod torque;

use crate::JOINTS;
use crate::arm::{Parameters, State};
use crate::link::limits::Limits;
use crate::link::message::Missing;
use crate::link::mode::{Fault, Guards};
use losses::Losses;
use motion::Motion;
use nalgebra::Vector2;
use samples::Samples;
use soft_stop::SoftStop;
use stuck::Stuck;
use torque::Torque;

pub(super) use ticks::InRow;

/// What is wrong, and by how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Violation {
    pub(super) fault: Fault,
    /// Which joint, counting from 0, if it is one.
    pub(super) joint: Option<u8>,
    /// What was seen, in the unit of the limit.
    pub(super) value: f32,
    /// What would have been allowed.
    pub(super) limit: f32,
}

impl Violation {
    /// Of no joint, and without numbers.
    pub(super) fn plain(fault: Fault) -> Self {
        Self {
            fault,
            joint: None,
            value: 0.0,
            limit: 0.0,
        }
    }
}

/// What one tick brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen<'a> {
    /// The samples.
    pub(super) counts: [Option<u16>; JOINTS],
    /// Why there is none; `None` where there is one.
    pub(super) missing: [Option<Missing>; JOINTS],
    /// The samples as angles.
    pub(super) measured_rad: [Option<f32>; JOINTS],
    /// Where the estimator expected them: its state before they were put in.
    pub(super) predicted_rad: [f32; JOINTS],
    /// The estimator begins with these samples: it expected nothing.
    pub(super) is_fresh: bool,
    /// Its state since.
    pub(super) state: &'a State<f32>,
    /// Torque that acted until these samples, in N m.
    pub(super) torque_nm: [f32; JOINTS],
    /// What of it gravity takes at these angles, in N m.
    pub(super) gravity_nm: [f32; JOINTS],
    /// The motors may be driven.
    pub(super) is_armed: bool,
}

/// A torque within all limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shaped {
    /// In N m.
    pub(super) torque_nm: Vector2<f32>,
    /// What was changed of the one that was wanted.
    pub(super) guards: Guards,
}

/// All monitors, for one set of limits and one period.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Guard {
    limits: Limits,
    losses: Losses,
    joints: [Joint; JOINTS],
    soft_stop: SoftStop,
    torque: Torque,
}

/// The monitors of one joint.
#[derive(Clone, Debug, PartialEq)]
struct Joint {
    samples: Samples,
    motion: Motion,
    stuck: Stuck,
}

impl Guard {
    /// For [valid](Limits::is_valid) limits and ticks of `period_us`.
    pub(super) fn new(limits: Limits, period_us: u32) -> Self {
        // Whoever asks: nothing is divided by zero.
        let period_us = period_us.max(1);
        let ([angle_a, angle_b], [speed_a, speed_b]) = (limits.angle_rad, limits.speed_rad_s);
        let joint = |angle_rad, speed_rad_s| Joint {
            samples: Samples::new(&limits),
            motion: Motion::new(angle_rad, speed_rad_s, period_us),
            stuck: Stuck::new(&limits, period_us),
        };
        Self {
            limits,
            losses: Losses::new(&limits, period_us),
            joints: [joint(angle_a, speed_a), joint(angle_b, speed_b)],
            soft_stop: SoftStop::new(limits.angle_rad, period_us),
            torque: Torque::new(&limits, period_us),
        }
    }

    pub(super) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// How many ticks in a row a joint must be faster than it may be.
    pub(super) fn fast_ticks(&self) -> u32 {
        let [first, _] = &self.joints;
        first.motion.fast_ticks()
    }

    /// The farthest angle in rad at which this joint may be so fast without being
    /// slowed before its angle limit.
    pub(super) fn farthest_rad(&self, joint: usize, speed_rad_s: f32) -> f32 {
        self.soft_stop.farthest_rad(joint, speed_rad_s)
    }

    /// The same as it was before it had seen anything.
    pub(super) fn as_built(&self) -> Self {
        let mut guard = self.clone();
        guard.restart();
        guard
    }

    /// Samples of this joint that are missing in a row, and how many may be.
    pub(super) fn lost_in_row(&self, joint: usize) -> (u32, u32) {
        self.losses.in_row(joint)
    }

    /// Torque comes on, or ticks begin anew: nothing has been seen yet.
    pub(super) fn restart(&mut self) {
        self.losses.restart();
        for joint in &mut self.joints {
            joint.samples.restart();
            joint.motion.restart();
            joint.stuck.restart();
        }
        self.torque.restart();
    }

    /// The samples that the estimator is given. One that is farther from where it is
    /// expected than the limit is not: a single one that is wrong and whose checksum
    /// is right, as one in 256 is on a bad line, moves no motor. Several are an
    /// estimator that has lost the arm, which [`Guard::judge`] says.
    pub(super) fn believe(
        &self,
        measured_rad: [Option<f32>; JOINTS],
        predicted_rad: [f32; JOINTS],
    ) -> [Option<f32>; JOINTS] {
        let mut believed = measured_rad;
        for (measured, predicted) in believed.iter_mut().zip(predicted_rad) {
            // A prediction that is not a number refuses none: it is judged later.
            let is_far = |rad: &f32| (rad - predicted).abs() > self.limits.innovation_rad;
            *measured = measured.filter(|rad| !is_far(rad));
        }
        believed
    }

    /// Judges what this tick brought, before the control law runs. With torque
    /// off the arm may be anywhere and be moved by anybody: all that is judged
    /// then is whether it is heard.
    ///
    /// # Errors
    /// What is wrong.
    pub(super) fn judge(&mut self, seen: &Seen<'_>) -> Result<(), Violation> {
        self.losses.judge(seen.missing)?;
        if !seen.is_armed {
            return Ok(());
        }
        let [angle, speed] = [seen.state.q, seen.state.dq].map(<[f32; JOINTS]>::from);
        finite([angle, speed, seen.torque_nm, seen.gravity_nm])?;
        let samples = seen.counts.into_iter().zip(seen.measured_rad);
        let states = angle.into_iter().zip(speed);
        let torques = seen.torque_nm.into_iter().zip(seen.gravity_nm);
        let rest = states.zip(torques).zip(seen.predicted_rad);
        for (((id, joint), (counts, measured)), (((q, dq), (torque, gravity)), predicted)) in
            (0..).zip(&mut self.joints).zip(samples).zip(rest)
        {
            if let Some(counts) = counts {
                joint.samples.place(id, counts)?;
                joint.stuck.judge(id, counts, torque - gravity)?;
            }
            if let (Some(measured), false) = (measured, seen.is_fresh) {
                joint.samples.innovation(id, measured - predicted)?;
            }
            joint.motion.judge(id, q, dq)?;
        }
        Ok(())
    }

    /// Makes of `wanted_nm` a torque within all limits, for an arm that will be at
    /// `state` when it begins to act, after `before_nm`.
    ///
    /// # Errors
    /// Something is not finite, or has been limited for too long.
    pub(super) fn shape(
        &mut self,
        arm: &Parameters<f32>,
        state: &State<f32>,
        wanted_nm: Vector2<f32>,
        before_nm: Vector2<f32>,
    ) -> Result<Shaped, Violation> {
        finite([wanted_nm, before_nm, state.q, state.dq].map(<[f32; JOINTS]>::from))?;
        let bounds = self.soft_stop.bounds(arm, state);
        let (wanted_nm, before_nm) = (wanted_nm.into(), before_nm.into());
        self.torque.shape(wanted_nm, before_nm, bounds)
    }

    /// Notes whether this tick's torque was more than the PWM's limit gives.
    ///
    /// # Errors
    /// It has been for too long.
    pub(super) fn pwm(&mut self, is_limited: bool) -> Result<(), Violation> {
        self.torque.pwm(is_limited)
    }
}

/// Whether all are, joint by joint.
fn finite(values: [[f32; JOINTS]; 4]) -> Result<(), Violation> {
    // Not finite if any of them is not, or if they are so large that a closer look
    // costs nobody anything.
    let sum: f32 = values.iter().flatten().map(|value| value.abs()).sum();
    if sum.is_finite() {
        return Ok(());
    }
    for (joint, value) in values.into_iter().flat_map(|values| (0..).zip(values)) {
        if !value.is_finite() {
            return Err(Violation {
                fault: Fault::NotFinite,
                joint: Some(joint),
                value,
                limit: f32::MAX,
            });
        }
    }
    Ok(())
}
