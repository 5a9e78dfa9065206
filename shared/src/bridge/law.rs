//! A set-up made ready: estimator, controller and actuators for one period.
//!
//! Building takes a Riccati solution, far too long for a tick; it is done on
//! the link's side, and the tick is handed the result as a whole.
//!
//! # Bumpless
//!
//! A set-up may be replaced while torque is on. The estimator goes on from the
//! state it is handed, and what the torque would jump by is added to it and
//! faded out, so that the servos see no step. So is a constant torque when the
//! arm is made to follow a reference. A setpoint elsewhere, and holding an arm
//! whose motors were off, are steps: they are asked for as such.

use core::num::NonZeroU64;
use nalgebra::Vector2;

use super::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
use crate::JOINTS;
use crate::actuator::{Command, Joint, Pwm};
use crate::arm::{Discrete, Parameters, State};
use crate::control::{
    ComputedTorque, Controller, DryFriction, Lqr, Reference, Tuning, Weights, computed_torque,
};
use crate::design::stability;
use crate::estimate::{Config, Estimator};
use crate::link::message::{self, Gains, Refusal, Settings, Setup};

/// Time constant in s with which a bump fades: slow beside the loop's own 50 ms,
/// so that it is no disturbance to speak of, and over within half a second.
const FADE_S: f32 = 0.1;

/// Whether a board can run with these settings: every limit is within its hard
/// bound, and there is a controller for the set-up.
pub fn can_run(settings: &Settings) -> bool {
    why_not(settings).is_none()
}

/// Why a board would refuse these settings; `None` if it would not.
pub fn why_not(settings: &Settings) -> Option<Refusal> {
    if settings.limits.is_valid() {
        Law::build(&settings.setup).err()
    } else {
        Some(Refusal::OutOfRange)
    }
}

/// What a tick computes with.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Law {
    period_us: NonZeroU64,
    arm: Parameters<f32>,
    joints: [Joint<f32>; JOINTS],
    estimator: Estimator<f32>,
    /// The estimator's model has dry friction, so it is told all of the torque.
    knows_friction: bool,
    controller: Controller<f32>,
    friction: DryFriction<f32>,
    /// What is still added to the torque since the set-up was replaced.
    bump_nm: Vector2<f32>,
    /// Share of it that is left a period later.
    fade: f32,
}

impl Law {
    /// Designs what `setup` asks for.
    pub(super) fn build(setup: &Setup) -> Result<Self, Refusal> {
        if !(PERIOD_MIN_US..=PERIOD_MAX_US).contains(&setup.period_us) {
            return Err(Refusal::OutOfRange);
        }
        let period_us = NonZeroU64::new(setup.period_us.into()).ok_or(Refusal::OutOfRange)?;
        let period_s = setup.period_us as f32 * 1e-6;
        let arm = setup.arm;
        let friction_is_valid = setup.friction_nm.iter().all(|nm| (0.0..=1.0).contains(nm));
        if !(arm.is_valid() && setup.joints.iter().all(Joint::is_valid) && friction_is_valid) {
            return Err(Refusal::OutOfRange);
        }
        let estimator = setup
            .estimator
            .build(&arm, period_s)
            .map_err(|_| Refusal::OutOfRange)?;
        let knows_friction =
            matches!(setup.estimator, Config::Kalman(tuning) if tuning.coulomb_nm > 0.0);
        Ok(Self {
            period_us,
            arm,
            joints: setup.joints,
            estimator,
            knows_friction,
            controller: controller(setup, &arm, period_s)?,
            friction: DryFriction::of(setup.friction_nm),
            bump_nm: Vector2::zeros(),
            fade: FADE_S / (period_s + FADE_S),
        })
    }

    pub(super) fn period_us(&self) -> NonZeroU64 {
        self.period_us
    }

    /// The servos, as they are believed in.
    pub(super) fn joints(&self) -> &[Joint<f32>; JOINTS] {
        &self.joints
    }

    /// Joint angles in rad for encoder counts.
    pub(super) fn angles(&self, counts: [Option<u16>; JOINTS]) -> [Option<f32>; JOINTS] {
        let ([joint_a, joint_b], [a, b]) = (&self.joints, counts);
        [
            a.map(|count| joint_a.angle(count)),
            b.map(|count| joint_b.angle(count)),
        ]
    }

    /// The estimator begins at rest at these angles, and nothing fades any more.
    pub(super) fn reset(&mut self, angle_rad: [f32; JOINTS]) {
        self.estimator.reset(angle_rad.into());
        self.bump_nm = Vector2::zeros();
    }

    /// Goes on where `before` is, without a step in the torque: its next demand
    /// at `reference` is what this law's shall be.
    pub(super) fn take_over(&mut self, before: &Self, reference: &Reference<f32>) {
        self.estimator.adopt(&before.estimator);
        let (demand_nm, _) = before.demand(&before.estimator.prior(), reference);
        self.fade_from(demand_nm, reference);
    }

    /// Begins to follow `reference` with this torque, and leaves it by and by.
    pub(super) fn fade_from(&mut self, torque_nm: Vector2<f32>, reference: &Reference<f32>) {
        self.bump_nm = Vector2::zeros();
        let (own_nm, _) = self.demand(&self.estimator.prior(), reference);
        self.bump_nm = torque_nm - own_nm;
    }

    /// The state at these samples.
    pub(super) fn correct(&mut self, measured_rad: [Option<f32>; JOINTS]) -> State<f32> {
        self.estimator.correct(measured_rad)
    }

    /// The state at the next samples, until which what was decided acts.
    pub(super) fn advance(&mut self, in_force: &Decision) -> State<f32> {
        self.bump_nm *= self.fade;
        let known_nm = if self.knows_friction {
            in_force.torque_nm + in_force.friction_nm
        } else {
            in_force.torque_nm
        };
        self.estimator.advance(known_nm)
    }

    /// Torque in N m that acts though nobody commanded it.
    pub(super) fn disturbance_nm(&self) -> [f32; JOINTS] {
        self.estimator.disturbance().into()
    }

    /// The whole torque that makes the arm follow, for the state and the reference of
    /// one instant, and the share of it that is meant for dry friction.
    pub(super) fn demand(
        &self,
        state: &State<f32>,
        reference: &Reference<f32>,
    ) -> (Vector2<f32>, Vector2<f32>) {
        let demand = self.controller.demand(&self.arm, state, reference);
        let friction_nm = self.friction.feed_forward(demand.feedback_nm, reference.dq);
        let torque_nm =
            demand.torque_nm + friction_nm + self.bump_nm - self.estimator.disturbance();
        (torque_nm, friction_nm)
    }

    /// Commands for a torque, at most `pwm_max` counts away from off; and whether
    /// that made a difference. `None` if the torque is not finite.
    pub(super) fn commands(
        &self,
        torque_nm: Vector2<f32>,
        friction_nm: Vector2<f32>,
        pwm_max: u16,
    ) -> Option<(Decision, bool)> {
        let [joint_a, joint_b] = &self.joints;
        let a = joint_a.command(torque_nm.x, pwm_max).ok()?;
        let b = joint_b.command(torque_nm.y, pwm_max).ok()?;
        Some(Decision::of([a, b], friction_nm))
    }

    /// The same, where a joint may be given a PWM exactly: if the torque is what it
    /// stands for.
    #[inline(never)]
    pub(super) fn commands_exactly(
        &self,
        exactly: [Option<Pwm>; JOINTS],
        torque_nm: Vector2<f32>,
        friction_nm: Vector2<f32>,
        pwm_max: u16,
    ) -> Option<(Decision, bool)> {
        let ([joint_a, joint_b], [exactly_a, exactly_b]) = (&self.joints, exactly);
        let a = command(joint_a, torque_nm.x, exactly_a, pwm_max)?;
        let b = command(joint_b, torque_nm.y, exactly_b, pwm_max)?;
        Some(Decision::of([a, b], friction_nm))
    }

    /// The same without what it has come to know of the arm since it was built.
    pub(super) fn as_built(&self) -> Self {
        let mut law = self.clone();
        law.estimator.reset(Vector2::zeros());
        law.bump_nm = Vector2::zeros();
        law
    }

    /// Numbers that a tick computes with, to be spoiled.
    pub(super) fn numbers(&mut self) -> [&mut f32; 8] {
        let [a, b] = &mut self.joints;
        [
            &mut self.arm.i1x,
            &mut self.arm.l1,
            &mut self.arm.m2,
            &mut self.fade,
            &mut a.zero_count,
            &mut a.gain_counts_per_nm,
            &mut b.rad_per_count,
            &mut b.offset_counts,
        ]
    }

    /// The arm that is believed in.
    pub(super) fn arm(&self) -> &Parameters<f32> {
        &self.arm
    }

    /// Where the next samples are expected.
    pub(super) fn prior(&self) -> State<f32> {
        self.estimator.prior()
    }

    /// Torque in N m that holds the arm against gravity in this state.
    pub(super) fn gravity_nm(&self, state: &State<f32>) -> Vector2<f32> {
        self.arm.gravity(state.q)
    }
}

/// The command for a torque, or this PWM if it stands for just that.
fn command(
    joint: &Joint<f32>,
    torque_nm: f32,
    exactly: Option<Pwm>,
    pwm_max: u16,
) -> Option<Command<f32>> {
    let is_meant = |pwm: &Pwm| joint.torque(*pwm) - torque_nm == 0.0;
    match exactly.filter(is_meant) {
        Some(pwm) if pwm == pwm.within(pwm_max) => Some(Command {
            pwm,
            torque_nm,
            is_limited: false,
        }),
        Some(_) | None => joint.command(torque_nm, pwm_max).ok(),
    }
}

fn controller(
    setup: &Setup,
    arm: &Parameters<f32>,
    period_s: f32,
) -> Result<Controller<f32>, Refusal> {
    match setup.controller {
        message::Controller::StateFeedback(gains) => {
            let model = arm.linearise(Vector2::zeros()).zero_order_hold(period_s);
            state_feedback(gains, &model).map(Controller::StateFeedback)
        }
        message::Controller::ComputedTorque {
            natural_rad_s,
            damping,
        } => {
            let tuning = Tuning {
                natural_rad_s,
                damping,
            };
            ComputedTorque::new(arm, &tuning, period_s)
                .map(Controller::ComputedTorque)
                .map_err(|error| match error {
                    computed_torque::Error::Unstable { radius, .. } => Refusal::Unstable {
                        re: radius,
                        im: 0.0,
                    },
                    computed_torque::Error::Period
                    | computed_torque::Error::Natural { .. }
                    | computed_torque::Error::Damping { .. } => Refusal::OutOfRange,
                })
        }
    }
}

/// The gain, if it stabilises the model.
fn state_feedback(gains: Gains, model: &Discrete<f32>) -> Result<Lqr<f32>, Refusal> {
    let lqr = match gains {
        // Made for one period; a board asked to run it elsewhere checks it too.
        Gains::Paper => Lqr::paper(),
        Gains::Design { q, r } => {
            return Lqr::design(model, &Weights { q, r }).map_err(|_| Refusal::NoGains);
        }
        Gains::Given([first, second]) => Lqr::of_rows(first, second),
    };
    let closed = model.a - model.b * lqr.gain;
    let eigenvalue = stability::dominant(&closed).ok_or(Refusal::OutOfRange)?;
    if eigenvalue.radius() < 1.0 {
        Ok(lqr)
    } else {
        Err(Refusal::Unstable {
            re: eigenvalue.re,
            im: eigenvalue.im,
        })
    }
}

/// What the servos are to be told, and the torque that it stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    pub(super) pwm: [Pwm; JOINTS],
    /// In N m, after clamp and rounding, less the share meant for dry friction.
    pub(super) torque_nm: Vector2<f32>,
    /// That share, in N m.
    pub(super) friction_nm: Vector2<f32>,
}

impl Decision {
    /// These commands, with the share of their torque that is meant for dry friction;
    /// and whether one of them was limited.
    fn of([a, b]: [Command<f32>; JOINTS], friction_nm: Vector2<f32>) -> (Self, bool) {
        let decision = Self {
            pwm: [a.pwm, b.pwm],
            torque_nm: Vector2::new(a.torque_nm, b.torque_nm) - friction_nm,
            friction_nm,
        };
        (decision, a.is_limited || b.is_limited)
    }

    /// Motors off.
    pub(super) fn off() -> Self {
        Self {
            pwm: [Pwm::OFF; JOINTS],
            torque_nm: Vector2::zeros(),
            friction_nm: Vector2::zeros(),
        }
    }
}
