//! Monitors: what every tick is held against, and what the torque is held to.
//!
//! ```text
//! samples, estimate -> judge -> control law -> limit -> PWM
//!                        |                       |
//!                        +------ Violation ------+--> torque off
//! ```
//!
//! [`Monitors::judge`] detects: it reports samples, an estimate or an arm that are not what
//! they would be if all were well. [`Monitors::limit`] prevents: it brakes a joint
//! before its angle limit and holds torque and its rate to their limits, and is a
//! violation only when it has to go on doing so. The first violation wins: what
//! follows is often its consequence.
//!
//! Nothing here reads a clock, looks at a mode or switches anything: ticks are
//! counted, and what follows from a violation is the supervisor's. The numbers
//! ([`MonitorConfig`]) are apart from what has been counted ([`Monitors`]).
//!
//! | module       | what                                                        |
//! |--------------|-------------------------------------------------------------|
//! | `dropout`    | a servo is silent, samples are lost in a row or too often   |
//! | `innovation` | an encoder is in its gap, the samples leave the estimator   |
//! | `motion`     | a joint is beyond its angle or its speed                    |
//! | `stall`      | a joint or its encoder does not move                        |
//! | `soft_stop`  | bounds of the torque within which the arm stays inside      |
//! | `torque`     | torque within all limits; braked or limited for too long    |
//! | `debounce`   | times as numbers of ticks, ticks in a row                   |
//! | `violation`  | what a monitor finds                                        |

mod debounce;
mod dropout;
mod innovation;
mod motion;
mod soft_stop;
mod stall;
#[cfg(test)]
mod tests;
mod torque;
mod violation;

use crate::JOINTS;
use crate::arm::{Parameters, State};
use crate::check_word::checked;
use crate::link::limits::Limits;
use crate::link::message::Missing;
use crate::link::mode::Fault;
use dropout::{Dropout, DropoutConfig};
use innovation::Innovation;
use motion::{Motion, MotionLimits};
use nalgebra::Vector2;
use soft_stop::SoftStop;
use stall::{Stall, StallConfig};
use torque::{LimitedTorque, TorqueConfig, TorqueLimiter};

pub(super) use debounce::Debounce;
pub use violation::Violation;

/// Samples in a row with an alarm. One may be damage that its checksum did not detect: one in
/// 256 does not. A servo that has switched torque off repeats its alarm.
const ALARM_SAMPLES: u32 = 2;

/// What one tick brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MonitorInput<'a> {
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
    /// The servo reports with its sample that it has switched torque off.
    pub(super) is_alarmed: [bool; JOINTS],
    /// The motors may be driven.
    pub(super) is_armed: bool,
}

/// The numbers of all monitors, for one set of limits and one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MonitorConfig {
    limits: Limits,
    dropout: DropoutConfig,
    fast_ticks: u32,
    stall: StallConfig,
    soft_stop: SoftStop,
    torque: TorqueConfig,
}

checked!(MonitorConfig {
    limits,
    dropout,
    fast_ticks,
    stall,
    soft_stop,
    torque,
});

/// What all monitors have counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Monitors {
    dropout: Dropout,
    joints: [JointMonitors; JOINTS],
    torque: TorqueLimiter,
}

/// The monitors of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct JointMonitors {
    innovation: Innovation,
    motion: Motion,
    stall: Stall,
    alarmed: Debounce,
}

impl MonitorConfig {
    /// For [valid](Limits::is_valid) limits and ticks of `period_us`.
    pub(super) fn new(limits: Limits, period_us: u32) -> Self {
        // Nothing is divided by zero, whatever is asked for.
        let period_us = period_us.max(1);
        Self {
            limits,
            dropout: DropoutConfig::new(&limits, period_us),
            fast_ticks: motion::fast_ticks(period_us),
            stall: StallConfig::new(&limits, period_us),
            soft_stop: SoftStop::new(limits.angle_rad, period_us),
            torque: TorqueConfig::new(&limits, period_us),
        }
    }

    pub(super) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// How many ticks in a row a joint must be faster than it may be.
    pub(super) fn fast_ticks(&self) -> u32 {
        self.fast_ticks
    }

    /// How many samples of a joint may be missing in a row.
    pub(super) fn dropout_ticks(&self) -> u32 {
        self.dropout.row_ticks()
    }

    /// The farthest angle in rad at which this joint may be so fast without being
    /// slowed before its angle limit.
    pub(super) fn farthest_rad(&self, joint: usize, speed_rad_s: f32) -> f32 {
        self.soft_stop.farthest_rad(joint, speed_rad_s)
    }

    /// The samples that the estimator is given. One that is farther from where it is
    /// expected than the limit is not: a single one that is wrong and whose checksum
    /// is right, as one in 256 is on a bad line, moves no motor. Several are an
    /// estimator that has lost the arm, which [`Monitors::judge`] detects.
    pub(super) fn gate_innovation(
        &self,
        measured_rad: [Option<f32>; JOINTS],
        predicted_rad: [f32; JOINTS],
    ) -> [Option<f32>; JOINTS] {
        let mut gated = measured_rad;
        for (measured, predicted) in gated.iter_mut().zip(predicted_rad) {
            // A prediction that is not a number refuses none: it is judged later.
            let is_far = |rad: &f32| (rad - predicted).abs() > self.limits.innovation_rad;
            *measured = measured.filter(|rad| !is_far(rad));
        }
        gated
    }
}

impl Monitors {
    /// Samples of this joint that are missing in a row.
    pub(super) fn lost_in_row(&self, joint: usize) -> u32 {
        self.dropout.in_row(joint)
    }

    /// Judges what this tick brought, before the control law runs. With torque
    /// off the arm may be anywhere and may be moved by hand: all that is judged
    /// then is whether its servos answer.
    ///
    /// # Errors
    /// What is wrong.
    pub(super) fn judge(
        &mut self,
        config: &MonitorConfig,
        seen: &MonitorInput<'_>,
    ) -> Result<(), Violation> {
        let limits = &config.limits;
        self.dropout.judge(&config.dropout, limits, seen.missing)?;
        if !seen.is_armed {
            return Ok(());
        }
        let [angle, speed] = [seen.state.q, seen.state.dq].map(<[f32; JOINTS]>::from);
        finite([angle, speed, seen.torque_nm, seen.gravity_nm])?;
        for (i, joint) in self.joints.iter_mut().enumerate() {
            let id = i as u8;
            if let Some(counts) = seen.counts[i] {
                if joint.alarmed.note(seen.is_alarmed[i], ALARM_SAMPLES) {
                    return Err(Violation {
                        joint: Some(id),
                        ..Violation::plain(Fault::ServoAlarm)
                    });
                }
                joint.innovation.place(limits, id, counts)?;
                let push_nm = seen.torque_nm[i] - seen.gravity_nm[i];
                joint
                    .stall
                    .judge(&config.stall, limits, id, counts, push_nm)?;
            }
            if let (Some(measured), false) = (seen.measured_rad[i], seen.is_fresh) {
                let off_rad = measured - seen.predicted_rad[i];
                joint.innovation.judge(limits, id, off_rad)?;
            }
            let most = MotionLimits {
                angle_rad: limits.angle_rad[i],
                speed_rad_s: limits.speed_rad_s[i],
                fast_ticks: config.fast_ticks,
            };
            joint.motion.judge(&most, id, angle[i], speed[i])?;
        }
        Ok(())
    }

    /// Puts `wanted_nm` within all limits, for an arm that will be at `state` when
    /// the torque begins to act, after `before_nm`.
    ///
    /// # Errors
    /// Something is not finite, or has been limited for too long.
    pub(super) fn limit(
        &mut self,
        config: &MonitorConfig,
        arm: &Parameters<f32>,
        state: &State<f32>,
        wanted_nm: Vector2<f32>,
        before_nm: Vector2<f32>,
    ) -> Result<LimitedTorque, Violation> {
        finite([wanted_nm, before_nm, state.q, state.dq].map(<[f32; JOINTS]>::from))?;
        let bounds = config.soft_stop.bounds(arm, state);
        let (wanted_nm, before_nm) = (wanted_nm.into(), before_nm.into());
        self.torque
            .shape(&config.torque, &config.limits, wanted_nm, before_nm, bounds)
    }

    /// Notes whether this tick's torque was more than the PWM's limit gives.
    ///
    /// # Errors
    /// It has been for too long.
    pub(super) fn note_pwm(
        &mut self,
        config: &MonitorConfig,
        is_limited: bool,
    ) -> Result<(), Violation> {
        self.torque.pwm(&config.torque, &config.limits, is_limited)
    }
}

/// Whether all are, joint by joint.
fn finite(values: [[f32; JOINTS]; 4]) -> Result<(), Violation> {
    // Not finite if any of them is not, or if they are so large that a closer look
    // costs nothing.
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
