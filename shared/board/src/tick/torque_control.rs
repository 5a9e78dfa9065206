//! Torque control: from the state at the next samples, and the reference there, to a torque.
//!
//! ```text
//! torque = feed-forward(reference) + feedback(reference - ahead) + integral + offset
//!          - disturbance + friction compensation
//! ```
//!
//! All in N m at the joints, positive as the angles. The disturbance is what acts on the arm
//! beside the motor, so the motor gives its opposite. The offset is left from a set-up that was
//! replaced, and fades out.

use super::config::{ControlConfig, LoopConfig};
use armbridge_control::arm::{Posture, State};
use armbridge_control::check_word::CheckWord;
use armbridge_control::controller::FloatState;
use armbridge_control::controller::friction::gear_torque;
use armbridge_control::trajectory::Reference;
use armbridge_servo::{JOINTS, Pwm};
use nalgebra::Vector2;

/// A torque in N m, and the friction compensation in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    pub(super) torque_nm: Vector2<f32>,
    pub(super) friction_nm: Vector2<f32>,
    /// PWM of the joints to which an experiment gives one; the torque is theirs.
    pub(super) exact_pwm: [Option<Pwm>; JOINTS],
}

impl Demand {
    /// A torque without friction compensation.
    pub(super) fn plain(torque_nm: Vector2<f32>) -> Self {
        Self {
            torque_nm,
            friction_nm: Vector2::zeros(),
            exact_pwm: [None; JOINTS],
        }
    }
}

/// Memory of the controller between two ticks.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TorqueControl {
    feed_forward: FeedForward,
    /// Torque offset since the set-up was replaced, which fades out.
    offset_nm: Vector2<f32>,
    /// Torque of the integral action.
    integral_nm: Vector2<f32>,
    /// Memory of a float, once it has begun.
    float: Option<FloatState<f32>>,
}

impl TorqueControl {
    /// Without offset and integral.
    pub(super) fn new() -> Self {
        Self {
            feed_forward: FeedForward::none(),
            offset_nm: Vector2::zeros(),
            integral_nm: Vector2::zeros(),
            float: None,
        }
    }

    /// Ends the offset: the estimate has begun anew.
    pub(super) fn end_offset(&mut self) {
        self.offset_nm = Vector2::zeros();
    }

    /// Lets the offset fade for a tick.
    pub(super) fn fade(&mut self, config: &ControlConfig) {
        self.offset_nm *= config.fade;
    }

    /// The torque for this state and reference, under this disturbance.
    pub(super) fn demand(
        &mut self,
        config: &ControlConfig,
        state: &State<f32>,
        reference: &Reference<f32>,
        disturbance_nm: Vector2<f32>,
    ) -> Demand {
        let forward_nm = self.feed_forward.at(config, reference);
        self.demand_with(config, state, reference, forward_nm, disturbance_nm)
    }

    fn demand_with(
        &self,
        config: &ControlConfig,
        state: &State<f32>,
        reference: &Reference<f32>,
        forward_nm: Vector2<f32>,
        disturbance_nm: Vector2<f32>,
    ) -> Demand {
        let demand = config
            .controller
            .demand(&config.arm, state, reference, forward_nm);
        let friction = &config.friction;
        let friction_nm = match friction.load {
            None => friction.feed_forward(demand.feedback_nm, reference.dq),
            Some(load) => {
                let rest_nm = self.integral_nm + self.offset_nm - disturbance_nm;
                let motor_nm = demand.torque_nm + rest_nm;
                let gears_nm = gear_torque_nm(config, state, motor_nm);
                let speed_rad_s = reference.dq;
                friction.loaded_feed_forward(demand.feedback_nm, speed_rad_s, load, gears_nm)
            }
        };
        Demand {
            torque_nm: demand.torque_nm + friction_nm + self.integral_nm + self.offset_nm
                - disturbance_nm,
            friction_nm,
            exact_pwm: [None; JOINTS],
        }
    }

    /// Begins to float in this state, under this torque until now, if the arm is driven.
    pub(super) fn begin_float(
        &mut self,
        config: &ControlConfig,
        state: &State<f32>,
        torque_nm: Option<Vector2<f32>>,
    ) {
        self.float = Some(config.float().begin(&config.arm, state, torque_nm));
    }

    /// The torque of an arm that floats, in this state. An estimator without friction gets the
    /// part of it under which its model goes on with its speed: hand, friction and errors of the
    /// model take the rest.
    pub(super) fn float_demand(&mut self, config: &ControlConfig, state: &State<f32>) -> Demand {
        let float = config.float();
        let begin = || float.begin(&config.arm, state, None);
        let memory = self.float.get_or_insert_with(begin);
        let float = float.torque(memory, &config.arm, state);
        Demand {
            friction_nm: float.torque_nm - float.balanced_nm,
            ..Demand::plain(float.torque_nm)
        }
    }

    /// Torque of the integral action in the next tick, after this one in which the reference
    /// is `lag_rad` ahead of the arm, and `sent_nm` is left of the demand. `None` where no
    /// controller drives the arm.
    pub(super) fn integrate(
        &mut self,
        config: &LoopConfig,
        lag_rad: Vector2<f32>,
        demand_nm: Option<Vector2<f32>>,
        sent_nm: Vector2<f32>,
    ) {
        let control = &config.control;
        let Some(integral) = &control.integral else {
            return;
        };
        self.integral_nm = demand_nm.map_or_else(Vector2::zeros, |demand_nm| {
            integral.next(
                self.integral_nm,
                lag_rad,
                demand_nm - sent_nm,
                // A count of PWM.
                [0, 1].map(|joint| 1.0 / control.joints[joint].gain_counts_per_nm.abs()),
                config.limits().torque_nm,
            )
        });
    }

    /// Torque in N m of this set-up, for its replacement without a step.
    pub(super) fn torque_nm(
        &self,
        config: &ControlConfig,
        state: &State<f32>,
        reference: &Reference<f32>,
        disturbance_nm: Vector2<f32>,
    ) -> Vector2<f32> {
        let forward_nm = feed_forward_nm(config, reference);
        self.demand_with(config, state, reference, forward_nm, disturbance_nm)
            .torque_nm
    }

    /// Begins an offset in N m, which decays within half a second.
    pub(super) fn begin_offset(&mut self, offset_nm: Vector2<f32>) {
        self.offset_nm = offset_nm;
    }

    /// Takes another set-up into use, whose integral action may have to begin.
    pub(super) fn install(&mut self, has_integral: bool) {
        self.feed_forward = FeedForward::none();
        if !has_integral {
            self.integral_nm = Vector2::zeros();
        }
    }
}

/// Cached feed-forward of the last reference: that of a setpoint is computed once, and
/// again if a bit of it turns.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct FeedForward {
    reference: Reference<f32>,
    torque_nm: Vector2<f32>,
    check: CheckWord,
}

impl FeedForward {
    /// An empty cache, whose reference equals none.
    fn none() -> Self {
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
    fn at(&mut self, config: &ControlConfig, reference: &Reference<f32>) -> Vector2<f32> {
        if self.reference != *reference || CheckWord::compute(&self.torque_nm) != self.check {
            *self = Self::new(reference, feed_forward_nm(config, reference));
        }
        self.torque_nm
    }
}

/// Torque in N m that the gears transmit under this one of the motors. Not inlined: only gears
/// with load friction need it.
#[inline(never)]
fn gear_torque_nm(
    config: &ControlConfig,
    state: &State<f32>,
    motor_nm: Vector2<f32>,
) -> Vector2<f32> {
    gear_torque(&config.arm, &Posture::of(state.q), state, motor_nm)
}

/// Feed-forward torque in N m of a reference.
fn feed_forward_nm(config: &ControlConfig, reference: &Reference<f32>) -> Vector2<f32> {
    config.controller.feed_forward(&config.arm, reference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::Settings;

    #[test]
    fn a_feed_forward_with_a_turned_bit_is_computed_again() {
        let config = LoopConfig::build(&Settings::default()).unwrap();
        let config = &config.control;
        let reference = Reference::at_rest(Vector2::new(0.3, -0.2));
        let true_nm = feed_forward_nm(config, &reference);
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
