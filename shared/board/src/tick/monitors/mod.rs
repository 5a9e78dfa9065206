//! Monitors: checks of every tick, and limits of the torque.
//!
//! ```text
//! samples, estimate -> check -> control law -> limit -> PWM
//!                        |                       |
//!                        +------ Violation ------+--> torque off
//! ```
//!
//! [`Monitors::check`] detects: it reports samples, an estimate or a motion of the arm that indicate
//! a fault. [`Monitors::limit`] prevents: it brakes a joint
//! before its angle limit and holds torque and its rate to their limits, and reports a
//! violation only when this lasts too long. The first violation counts: later ones
//! are often its consequence.
//!
//! The monitors read no clock and no mode, and switch nothing: they count ticks, and the
//! supervisor reacts to a violation. The parameters
//! ([`MonitorConfig`]) are separate from the counters ([`Monitors`]).
//!
//! | module       | content                                                     |
//! |--------------|-------------------------------------------------------------|
//! | `dropout`    | silent servos, samples lost in a row or too often           |
//! | `input`      | what the monitors see in a tick                             |
//! | `innovation` | encoder in its gap, samples far from the prediction         |
//! | `motion`     | angle and speed limits of a joint                           |
//! | `stall`      | joints that are driven and do not move                      |
//! | `encoder_noise` | noise of the encoders, and the runs of equal counts that it explains |
//! | `encoder_proof` | encoders that have stopped: a small motion must show     |
//! | `external_torque` | torque that the model does not explain                 |
//! | `soft_stop`  | bounds of the torque within which the arm stays inside      |
//! | `torque`     | torque within all limits; braked or limited for too long    |
//! | `debounce`   | times as numbers of ticks, ticks in a row                   |

mod debounce;
mod dropout;
mod encoder_noise;
mod encoder_proof;
mod external_torque;
mod innovation;
mod input;
mod motion;
mod soft_stop;
mod stall;
#[cfg(test)]
mod tests;
mod torque;

use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_control::check_word::checked;
use armbridge_control::encoder::Encoder;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_servo::JOINTS;
use dropout::{Dropout, DropoutConfig};
use encoder_noise::EncoderNoise;
use encoder_proof::{EncoderProof, ProofConfig};
use external_torque::{ExternalTorque, ExternalTorqueConfig};
use innovation::Innovation;
use motion::{Motion, MotionLimits};
use nalgebra::Vector2;
use soft_stop::{Bounds, SoftStop};
use stall::{Stall, StallConfig};
use torque::{LimitedTorque, TorqueConfig, TorqueLimiter};

use super::lowering::Lowered;
use armbridge_link::record::Violation;
pub(super) use debounce::Debounce;
pub(super) use external_torque::JointBalance;
pub(super) use input::{Hold, MonitorInput};

/// Samples in a row with an alarm. One may be damage that its checksum did not detect: one in
/// 256 is not detected. A servo that has switched torque off repeats its alarm.
const ALARM_SAMPLES: u32 = 2;

/// Parameters of all monitors, for one set of limits and one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MonitorConfig {
    limits: Limits,
    /// Encoders of the servos.
    encoders: [Encoder; JOINTS],
    /// Angle limits in rad: those of the host, within the reach of the servos.
    angle_rad: [f32; JOINTS],
    dropout: DropoutConfig,
    fast_ticks: u32,
    stall: StallConfig,
    proof: ProofConfig,
    external: ExternalTorqueConfig,
    soft_stop: SoftStop,
    torque: TorqueConfig,
}

checked!(MonitorConfig {
    limits,
    encoders,
    angle_rad,
    dropout,
    fast_ticks,
    stall,
    proof,
    external,
    soft_stop,
    torque,
});

/// Counters of all monitors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Monitors {
    dropout: Dropout,
    joints: [JointMonitors; JOINTS],
    torque: TorqueLimiter,
    /// Learnt in a session of the host; no restart within it resets this.
    noise: [EncoderNoise; JOINTS],
}

/// The monitors of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct JointMonitors {
    innovation: Innovation,
    motion: Motion,
    stall: Stall,
    proof: EncoderProof,
    external: ExternalTorque,
    alarmed: Debounce,
}

impl MonitorConfig {
    /// Parameters for [valid](Limits::is_valid) limits, these servos and ticks of
    /// `period_us`. No joint may go beyond what its servo's counts allow.
    pub(super) fn new(limits: Limits, joints: &[Joint<f32>; JOINTS], period_us: u32) -> Self {
        // Never a division by zero, whatever the setting.
        let period_us = period_us.max(1);
        let reach_rad = joints.each_ref().map(Joint::reach_rad);
        let angle_rad = core::array::from_fn(|joint| limits.angle_rad[joint].min(reach_rad[joint]));
        Self {
            limits,
            // A calibration that is valid is of an encoder.
            encoders: joints
                .each_ref()
                .map(|joint| joint.encoder().unwrap_or(Encoder::Ax12a)),
            angle_rad,
            dropout: DropoutConfig::new(&limits, period_us),
            fast_ticks: motion::fast_ticks(period_us),
            stall: StallConfig::new(period_us),
            proof: ProofConfig::new(&limits, period_us),
            external: ExternalTorqueConfig::new(period_us),
            soft_stop: SoftStop::new(angle_rad, period_us),
            torque: TorqueConfig::new(&limits, period_us),
        }
    }

    pub(super) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Number of consecutive ticks above the speed limit that is a violation.
    pub(super) fn fast_ticks(&self) -> u32 {
        self.fast_ticks
    }

    /// Number of consecutive missing samples of a joint that is a violation.
    pub(super) fn dropout_ticks(&self) -> u32 {
        self.dropout.row_ticks()
    }

    /// The first joint beyond its angle limit, at these angles in rad.
    pub(super) fn beyond_limit(&self, angle_rad: [f32; JOINTS]) -> Option<u8> {
        let mut joints = (0..).zip(angle_rad.into_iter().zip(self.angle_rad));
        let beyond = joints.find(|(_, (angle, limit))| angle.is_nan() || angle.abs() > *limit);
        beyond.map(|(joint, _)| joint)
    }

    /// The farthest angle in rad at which this joint with this speed is not braked before its
    /// angle limit.
    pub(super) fn farthest_rad(&self, joint: usize, speed_rad_s: f32) -> f32 {
        self.soft_stop.farthest_rad(joint, speed_rad_s)
    }

    /// Gates the samples for the estimator by their innovation. A sample beyond the limit is
    /// dropped: a single wrong one whose checksum is right, as one in 256 is on a bad line,
    /// moves no motor. Several in a row are an estimator that has diverged, which
    /// [`Monitors::check`] detects.
    pub(super) fn gate_innovation(
        &self,
        measured_rad: [Option<f32>; JOINTS],
        predicted_rad: [f32; JOINTS],
    ) -> [Option<f32>; JOINTS] {
        let mut gated = measured_rad;
        for (measured, predicted) in gated.iter_mut().zip(predicted_rad) {
            // A prediction that is NaN drops none: it is checked later.
            let is_far = |rad: &f32| (rad - predicted).abs() > self.limits.innovation_rad;
            *measured = measured.filter(|rad| !is_far(rad));
        }
        gated
    }
}

impl Monitors {
    /// The monitors at a restart: all counters at zero; the encoders' noise stays known.
    pub(super) fn restarted(&self) -> Self {
        Self {
            noise: self.noise,
            ..Self::default()
        }
    }

    /// The first joint, of this number, whose encoder has not shown its noise.
    pub(super) fn unknown_encoder(&self, joints: usize) -> Option<u8> {
        let mut noise = (0..).zip(&self.noise).take(joints);
        let unknown = noise.find(|(_, noise)| !noise.is_known());
        unknown.map(|(joint, _)| joint)
    }

    /// Variance of the noise of each encoder, in rad².
    pub(super) fn noise_rad2(&self, joints: &[Joint<f32>; JOINTS]) -> [f32; JOINTS] {
        core::array::from_fn(|joint| {
            let rad_per_count = joints[joint].rad_per_count;
            self.noise[joint].variance() * rad_per_count * rad_per_count
        })
    }

    /// Samples of this joint that are missing in a row.
    pub(super) fn lost_in_row(&self, joint: usize) -> u32 {
        self.dropout.in_row(joint)
    }

    /// Checks the inputs of this tick, before the control law runs. With torque
    /// off the arm may be anywhere and may be moved by hand: then only the
    /// dropouts are checked.
    ///
    /// # Errors
    /// The first violation.
    pub(super) fn check(
        &mut self,
        config: &MonitorConfig,
        input: &MonitorInput<'_>,
    ) -> Result<(), Violation> {
        let limits = &config.limits;
        self.dropout.check(&config.dropout, limits, input.missing)?;
        self.learn_noise(input);
        if !input.is_armed {
            return Ok(());
        }
        let [angle, speed] = [input.state.q, input.state.dq].map(<[f32; JOINTS]>::from);
        finite([angle, speed, input.torque_nm, input.gravity_nm])?;
        for (i, (joint, noise)) in self.joints.iter_mut().zip(&self.noise).enumerate() {
            let id = i as u8;
            let is_lowered = input.lowered[i];
            if let Some(counts) = input.counts[i] {
                if joint.alarmed.count(input.is_alarmed[i], ALARM_SAMPLES) {
                    return Err(Violation {
                        joint: Some(id),
                        ..Violation::plain(Fault::ServoAlarm)
                    });
                }
                if !is_lowered {
                    let encoder = config.encoders[i];
                    joint.innovation.check_range(encoder, limits, id, counts)?;
                }
                if joint.proof.is_repeated(counts) {
                    let held = input.held(limits, i);
                    joint.proof.check(&config.proof, noise, id, held.as_ref())?;
                }
                let push_nm = input.torque_nm[i] - input.gravity_nm[i];
                if !is_lowered {
                    joint
                        .stall
                        .check(config.stall, limits, id, counts, push_nm)?;
                }
            }
            if let (Some(measured), false) = (input.measured_rad[i], input.is_fresh) {
                let innovation_rad = measured - input.predicted_rad[i];
                joint
                    .innovation
                    .check_innovation(limits, id, innovation_rad)?;
            }
            let motion_limits = MotionLimits {
                angle_rad: if is_lowered {
                    f32::INFINITY
                } else {
                    config.angle_rad[i]
                },
                speed_rad_s: limits.speed_rad_s[i],
                fast_ticks: config.fast_ticks,
            };
            joint.motion.check(&motion_limits, id, angle[i], speed[i])?;
            match &input.hold {
                Hold::Controlled(balance) if !is_lowered => {
                    let (limit_nm, balance) = (limits.external_nm[i], balance[i]);
                    joint
                        .external
                        .check(&config.external, limit_nm, id, balance, speed[i])?;
                }
                // A hand may have any torque, and so may the table under a joint that is lowered.
                Hold::None | Hold::Floating | Hold::Controlled(_) => {
                    joint.external = ExternalTorque::default();
                }
            }
        }
        Ok(())
    }

    /// Learns the encoders' noise, until it is settled and whenever motors are off.
    fn learn_noise(&mut self, input: &MonitorInput<'_>) {
        for (noise, counts) in self.noise.iter_mut().zip(input.counts) {
            match counts {
                Some(counts) if !(input.is_armed && noise.is_settled()) => noise.take(counts),
                Some(_) | None => noise.pause(),
            }
        }
    }

    /// Limits the demand `wanted_nm`, for an arm that will be at `state` when
    /// the torque begins to act, after `before_nm`. No soft stop holds the joints that are lowered.
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
        lowered: Lowered,
    ) -> Result<LimitedTorque, Violation> {
        finite([wanted_nm, before_nm, state.q, state.dq].map(<[f32; JOINTS]>::from))?;
        let bounds = config.soft_stop.bounds(arm, state);
        let bounds = bounds.map(|bounds| free_lowered(bounds, lowered));
        let (wanted_nm, before_nm) = (wanted_nm.into(), before_nm.into());
        self.torque
            .limit(&config.torque, &config.limits, wanted_nm, before_nm, bounds)
    }

    /// The torque in N m of joints that a controller holds, which demands `demand_nm`: another
    /// one for those whose encoder proves itself.
    pub(super) fn proved(
        &self,
        config: &MonitorConfig,
        demand_nm: Vector2<f32>,
        gravity_nm: Vector2<f32>,
    ) -> Vector2<f32> {
        let torque = |joint: usize| {
            let proof = &self.joints[joint].proof;
            proof.torque(&config.proof, demand_nm[joint], gravity_nm[joint])
        };
        Vector2::from([torque(0), torque(1)])
    }

    /// Counts a tick whose torque exceeded the PWM limit.
    ///
    /// # Errors
    /// The limit has been exceeded for too long.
    pub(super) fn note_pwm(
        &mut self,
        config: &MonitorConfig,
        is_limited: bool,
    ) -> Result<(), Violation> {
        self.torque.pwm(&config.torque, &config.limits, is_limited)
    }
}

/// These bounds of the soft stop, without those of joints that are lowered.
fn free_lowered(bounds: [Bounds; JOINTS], lowered: Lowered) -> [Bounds; JOINTS] {
    let bounds = |joint: usize| {
        if lowered[joint] {
            Bounds::FREE
        } else {
            bounds[joint]
        }
    };
    [bounds(0), bounds(1)]
}

/// Checks that all values are finite, joint by joint.
fn finite(values: [[f32; JOINTS]; 4]) -> Result<(), Violation> {
    // The sum is not finite if a value is not, or if values are so large that the slow
    // path is harmless.
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
