//! Sense: the samples of a tick as counts and angles, and the command under which they were
//! taken.
//!
//! Angles have the sign of the arm's model ([`armbridge_control::arm`]), and torques that of the
//! angles; the sign of a servo that is mounted the other way is in its calibration
//! ([`Joint`](armbridge_control::actuator::Joint)). A missing sample is `None`, never a number. A
//! joint that the arm does not have rests at 0.

use super::actuator_command::ActuatorCommand;
use super::config::ControlConfig;
use armbridge_link::message::{Missing, Sample};
use armbridge_link::record::TickInput;
use armbridge_servo::{Alarms, JOINTS, Pwm};
use nalgebra::Vector2;

/// Alarms upon which a stock servo with factory settings switches its torque off.
const SHUTDOWN: Alarms = Alarms::OVERHEATING
    .or(Alarms::OVERLOAD)
    .or(Alarms::HARDWARE);

/// See the [module](self).
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensed {
    pub(super) counts: [Option<u16>; JOINTS],
    /// Reason for each missing sample.
    pub(super) missing: [Option<Missing>; JOINTS],
    /// The samples, in rad.
    pub(super) measured_rad: [Option<f32>; JOINTS],
    /// Whether the servo reports an alarm with which it has switched torque off.
    pub(super) is_alarmed: [bool; JOINTS],
    /// Command in force, sent at the beginning of this tick.
    pub(super) in_force: ActuatorCommand,
    /// Its torque in N m, with the friction compensation.
    pub(super) torque_nm: Vector2<f32>,
}

impl Sensed {
    /// The samples of `input`. `decided`, the command of the tick before, is in force if its
    /// PWM was sent; otherwise motors are off.
    pub(super) fn new(
        config: &ControlConfig,
        input: &TickInput,
        decided: &ActuatorCommand,
    ) -> Self {
        let in_force = if decided.pwm.map(Pwm::counts) == input.pwm_in_force {
            *decided
        } else {
            ActuatorCommand::OFF
        };
        let counts = input.samples.map(Sample::counts);
        let mut missing = input.samples.map(Sample::missing);
        let mut measured_rad = config.angles(counts);
        if config.joint_count < JOINTS {
            (missing[1], measured_rad[1]) = (None, Some(0.0));
        }
        Self {
            counts,
            missing,
            measured_rad,
            is_alarmed: input.alarms.map(switches_off),
            in_force,
            torque_nm: in_force.total_nm(),
        }
    }
}

/// Whether a servo with this error byte switches its torque off.
fn switches_off(alarms: u8) -> bool {
    !Alarms::from_bits(alarms).and(SHUTDOWN).is_empty()
}
