//! Control pipeline: from state and reference to the commands of the servos.
//!
//! ```text
//! state, reference -> demand -> (limits) -> commands -> PWM
//! ```

use nalgebra::Vector2;

use super::config::ControlConfig;
use armbridge_control::actuator::{Command, Joint};
use armbridge_control::arm::State;
use armbridge_control::check_word::CheckWord;
use armbridge_control::trajectory::Reference;
use armbridge_servo::{JOINTS, Pwm};

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

    /// Combines the commands of the joints with the friction compensation in them; and
    /// whether one of them was limited.
    fn from_commands(commands: [Command<f32>; JOINTS], friction_nm: Vector2<f32>) -> (Self, bool) {
        let torque_nm = Vector2::from(commands.map(|command| command.torque_nm));
        let command = Self {
            pwm: commands.map(|command| command.pwm),
            torque_nm: torque_nm - friction_nm,
            friction_nm,
        };
        (command, commands.iter().any(|command| command.is_limited))
    }
}

/// A torque in N m, and the friction compensation in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    pub(super) torque_nm: Vector2<f32>,
    pub(super) friction_nm: Vector2<f32>,
}

/// Cached feed-forward of the last reference: that of a setpoint is computed once, and
/// again if a bit of it turns.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct FeedForward {
    reference: Reference<f32>,
    torque_nm: Vector2<f32>,
    check: CheckWord,
}

impl FeedForward {
    /// An empty cache, whose reference equals none.
    pub(super) fn none() -> Self {
        Self::new(
            &Reference::at_rest([f32::NAN; JOINTS].into()),
            Vector2::zeros(),
        )
    }

    fn new(reference: &Reference<f32>, torque_nm: Vector2<f32>) -> Self {
        Self {
            reference: *reference,
            torque_nm,
            check: CheckWord::compute(&torque_nm),
        }
    }

    /// The feed-forward in N m of this reference.
    pub(super) fn at(
        &mut self,
        config: &ControlConfig,
        reference: &Reference<f32>,
    ) -> Vector2<f32> {
        if self.reference != *reference || CheckWord::compute(&self.torque_nm) != self.check {
            *self = Self::new(reference, config.feed_forward(reference));
        }
        self.torque_nm
    }
}

impl ControlConfig {
    /// Feed-forward torque in N m of a reference.
    pub(super) fn feed_forward(&self, reference: &Reference<f32>) -> Vector2<f32> {
        self.controller.feed_forward(&self.arm, reference)
    }

    /// The torque in N m of a command that the estimator's model has no friction against.
    pub(super) fn known_torque(&self, in_force: &ActuatorCommand) -> Vector2<f32> {
        if self.knows_friction {
            in_force.total_nm()
        } else {
            in_force.torque_nm
        }
    }

    /// Controller output for state, reference and feed-forward of one instant, before the
    /// estimated disturbance is subtracted.
    pub(super) fn demand(
        &self,
        state: &State<f32>,
        reference: &Reference<f32>,
        forward_nm: Vector2<f32>,
    ) -> Demand {
        let demand = self
            .controller
            .demand(&self.arm, state, reference, forward_nm);
        let friction_nm = self.friction.feed_forward(demand.feedback_nm, reference.dq);
        Demand {
            torque_nm: demand.torque_nm + friction_nm,
            friction_nm,
        }
    }

    /// Commands for a torque, at most `pwm_max` counts away from off; and whether
    /// one was limited. `None` if the torque is not finite.
    pub(super) fn commands(
        &self,
        torque_nm: Vector2<f32>,
        friction_nm: Vector2<f32>,
        pwm_max: u16,
    ) -> Option<(ActuatorCommand, bool)> {
        let [joint_a, joint_b] = &self.joints;
        let a = joint_a.command(torque_nm.x, pwm_max).ok()?;
        let b = joint_b.command(torque_nm.y, pwm_max).ok()?;
        Some(ActuatorCommand::from_commands([a, b], friction_nm))
    }

    /// The same with an exact PWM for some joints, used where the torque equals that of
    /// the PWM.
    #[inline(never)]
    pub(super) fn commands_with_pwm(
        &self,
        exact_pwm: [Option<Pwm>; JOINTS],
        torque_nm: Vector2<f32>,
        friction_nm: Vector2<f32>,
        pwm_max: u16,
    ) -> Option<(ActuatorCommand, bool)> {
        let ([joint_a, joint_b], [pwm_a, pwm_b]) = (&self.joints, exact_pwm);
        let a = command(joint_a, torque_nm.x, pwm_a, pwm_max)?;
        let b = command(joint_b, torque_nm.y, pwm_b, pwm_max)?;
        Some(ActuatorCommand::from_commands([a, b], friction_nm))
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control_loop::LoopConfig;
    use armbridge_link::message::Settings;

    #[test]
    fn a_feed_forward_with_a_turned_bit_is_computed_again() {
        let config = LoopConfig::build(&Settings::default()).unwrap();
        let config = &config.control;
        let reference = Reference::at_rest(Vector2::new(0.3, -0.2));
        let true_nm = config.feed_forward(&reference);
        let mut feed_forward = FeedForward::none();
        for bit in 0..u32::BITS {
            assert_eq!(feed_forward.at(config, &reference), true_nm);
            let torque = &mut feed_forward.torque_nm.x;
            *torque = f32::from_bits(torque.to_bits() ^ 1 << bit);
        }
        assert_eq!(feed_forward.at(config, &reference), true_nm);
        let elsewhere = Reference::at_rest(Vector2::zeros());
        assert_eq!(feed_forward.at(config, &elsewhere), Vector2::zeros());
    }
}
