//! Actuator command: a PWM for each servo, and the torque that it stands for.
//!
//! [`limit`] makes one of a demand, within all limits. The torque of a command is what is left
//! after clamp and rounding, so that estimator and integral action know what the motors were
//! given, not what was wanted.

use super::config::LoopConfig;
use super::lowering::Lowered;
use super::monitors::Monitors;
use super::torque_control::Demand;
use armbridge_control::actuator::{Command, Joint};
use armbridge_control::arm::State;
use armbridge_link::message::{Fault, Guards};
use armbridge_link::record::Violation;
use armbridge_servo::{JOINTS, Pwm};
use nalgebra::Vector2;

/// A command to the servos, and the torque that it produces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ActuatorCommand {
    /// PWM of each joint.
    pub pwm: [Pwm; JOINTS],
    /// Torque in N m, after clamp and rounding, without the friction compensation.
    pub torque_nm: Vector2<f32>,
    /// Friction compensation in the torque, in N m.
    pub friction_nm: Vector2<f32>,
}

impl ActuatorCommand {
    /// Motors off.
    pub const OFF: Self = Self {
        pwm: [Pwm::OFF; JOINTS],
        torque_nm: Vector2::new(0.0, 0.0),
        friction_nm: Vector2::new(0.0, 0.0),
    };

    /// Torque in N m, with the friction compensation.
    pub fn total_nm(&self) -> Vector2<f32> {
        self.torque_nm + self.friction_nm
    }

    /// Torque in N m that an estimator predicts with: the whole one if its model has dry friction,
    /// which takes its part.
    pub(super) fn known_nm(&self, knows_friction: bool) -> Vector2<f32> {
        if knows_friction {
            self.total_nm()
        } else {
            self.torque_nm
        }
    }
}

/// The command for a demand, within all limits, and the limits that changed it; for an arm that
/// will be at `ahead` when it begins to act, after a command of `before_nm`. Motors are off without
/// a demand.
///
/// The order is that of the [monitors](super::monitors): torque, soft stop, rate; then the PWM,
/// which is at most `limits.pwm_counts` away from off.
///
/// # Errors
/// Something is not finite, or has been limited for too long.
#[inline]
pub(super) fn limit(
    config: &LoopConfig,
    monitors: &mut Monitors,
    ahead: &State<f32>,
    demand: Option<Demand>,
    before_nm: Vector2<f32>,
    lowered: Lowered,
) -> Result<(ActuatorCommand, Guards), Violation> {
    let Some(demand) = demand else {
        return Ok((ActuatorCommand::OFF, Guards::NONE));
    };
    let control = &config.control;
    let limited = monitors.limit(
        &config.monitors,
        &control.arm,
        ahead,
        demand.torque_nm,
        before_nm,
        lowered,
    )?;
    let (torque_nm, pwm_max) = (limited.torque_nm, config.limits().pwm_counts);
    let commands = if demand.exact_pwm == [None; JOINTS] {
        commands(&control.joints, torque_nm, pwm_max)
    } else {
        commands_with_pwm(&control.joints, demand.exact_pwm, torque_nm, pwm_max)
    };
    let [a, b] = commands.ok_or(Violation::plain(Fault::NotFinite))?;
    let b = if config.joints() < JOINTS {
        // No servo of ours.
        Command {
            pwm: Pwm::OFF,
            torque_nm: 0.0,
            is_limited: false,
        }
    } else {
        b
    };
    let is_limited = a.is_limited || b.is_limited;
    monitors.note_pwm(&config.monitors, is_limited)?;
    let command = ActuatorCommand {
        pwm: [a.pwm, b.pwm],
        torque_nm: Vector2::new(a.torque_nm, b.torque_nm) - demand.friction_nm,
        friction_nm: demand.friction_nm,
    };
    let guards = if is_limited {
        limited.guards.or(Guards::PWM)
    } else {
        limited.guards
    };
    Ok((command, guards))
}

/// Commands of both joints; `None` if the torque is not finite.
fn commands(
    [a, b]: &[Joint<f32>; JOINTS],
    torque_nm: Vector2<f32>,
    pwm_max: u16,
) -> Option<[Command<f32>; JOINTS]> {
    let a = a.command(torque_nm.x, pwm_max).ok()?;
    let b = b.command(torque_nm.y, pwm_max).ok()?;
    Some([a, b])
}

/// The same with an exact PWM for some joints. Not inlined: only experiments have one.
#[inline(never)]
fn commands_with_pwm(
    [a, b]: &[Joint<f32>; JOINTS],
    [pwm_a, pwm_b]: [Option<Pwm>; JOINTS],
    torque_nm: Vector2<f32>,
    pwm_max: u16,
) -> Option<[Command<f32>; JOINTS]> {
    let a = command(a, torque_nm.x, pwm_a, pwm_max)?;
    let b = command(b, torque_nm.y, pwm_b, pwm_max)?;
    Some([a, b])
}

/// The command for a torque, or this PWM if it has exactly that torque.
fn command(
    joint: &Joint<f32>,
    torque_nm: f32,
    exact_pwm: Option<Pwm>,
    pwm_max: u16,
) -> Option<Command<f32>> {
    let has_torque = |pwm: &Pwm| joint.torque(*pwm) - torque_nm == 0.0;
    match exact_pwm.filter(has_torque) {
        Some(pwm) if pwm == pwm.within(pwm_max) => Some(Command {
            pwm,
            torque_nm,
            is_limited: false,
        }),
        Some(_) | None => joint.command(torque_nm, pwm_max).ok(),
    }
}
