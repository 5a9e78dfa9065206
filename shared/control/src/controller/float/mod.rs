//! Float: a torque under which the arm weighs nothing, stays where a hand leaves it, and is led by
//! the hand.
//!
//! ```text
//! u = G(q) (1 + s) + t + F(q) + C(v) - B(q, v)
//!     |       |      |   |      |       +-- brake beyond a speed, and before the ends
//!     |       |      |   +      +---------- part of the model's friction, in the direction of motion
//!     |       |      |   +----------------- virtual dry friction
//!     +-------+------+--------------------- gravity: of the model, and what was weighed at rest
//! ```
//!
//! The model's gravity is a tenth off, or more, and an arm under it alone would drift. So a
//! virtual dry friction `F` holds the arm, firmly wherever it has come to rest, until its load has
//! been taken over as weight that the model does not have; from then on it is light.
//!
//! # Virtual dry friction
//!
//! A spring from the joint to an anchor, which slips when the load is more than the strength of
//! the friction (Prandtl's element). It holds without creep, and gives back what its spring has
//! stored and no more. Nor is `v` an estimated speed: it is that of the angle without reversals of
//! less than twice [`REACH_RAD`].
//!
//! | joint                             | strength                                            |
//! |-----------------------------------|-----------------------------------------------------|
//! | at rest, not yet weighed          | firm: [`FIRM_SHARE`] of its weight                  |
//! | at rest, weighed                  | [`HELD_RATIO`] times light                          |
//! | in motion, before it has been weighed the first time | firm                             |
//! | in motion                         | light: [`LIGHT_SHARE`] of its weight, or [`LIGHT_DRY_SHARE`] of its dry friction, if that is more |
//! | beyond [`END_RAD`], moving outward | firm                                               |
//!
//! # Weighing
//!
//! A joint rests when it has moved slower than [`REST_RAD_S`] for [`REST_S`]. The load of `F` is
//! then taken over at a rate of [`TRANSFER_PER_S`]: anchor and torques change together, so that
//! their sum stays what it is, and nothing moves. Part of the load becomes the scale `s` of the
//! joint's gravity, which goes with the arm wherever it is led; the rest is the trim `t` of this
//! place, which fades over [`FADE_RAD`] of the motion that it drives. Both together are at most
//! [`CORRECTION_SHARE`] of the joint's weight. The load of a hand that holds the arm at rest is
//! taken over, too, and fades in the same way.
//!
//! In motion the trim grows against it by [`CATCH_NM_S`]: an error of the weight that dry
//! friction has hidden sets off no motion that lasts.
//!
//! # Passivity
//!
//! The motors give no power that is not a hand's or gravity's:
//!
//! * `G(q) (1 + s)` and the spring of `F` are potentials, and slip dissipates.
//! * `C` is [`FRICTION_SHARE`] of the model's friction, up to a speed. With a motor that is
//!   [`MOTOR_RATIO`] times as strong as believed, and true friction only [`FRICTION_RATIO`] of the
//!   model's, it exceeds the true friction by no more than a light `F` takes.
//! * `B` opposes the motion.
//! * `s` and `t` grow at rest, or against the motion, to their bounds; `t` fades where it drives.
//!
//! # Period
//!
//! Up to [`PERIOD_MAX_US`]. Torques in N m, positive as the angles; angles in rad, speeds in
//! rad/s.
//!
//! # Example
//!
//! An arm that is a fifth heavier than the model is weighed within seconds, and stays where it leans:
//!
//! ```
//! use armbridge_control::arm::{Parameters, State};
//! use armbridge_control::controller::Float;
//! use nalgebra::Vector2;
//!
//! let model = Parameters::<f64>::paper();
//! let heavier = Parameters { g: 1.2 * model.g, ..model };
//! let leaning = State::at_rest(Vector2::new(0.6, -0.3));
//! let (float, mut state) = (Float::new(&model, [0.04; 2], 1e-3), leaning);
//! let mut memory = float.begin(&model, &leaning, None);
//! for _ in 0..6_000 {
//!     let torque = float.torque(&mut memory, &model, &state).torque_nm;
//!     state.dq += heavier.acceleration(&state, torque) * 1e-3;
//!     state.q += state.dq * 1e-3;
//! }
//! assert!((state.q - leaning.q).amax() < 0.03 && state.dq.amax() < 1e-3, "{state:?}");
//! ```

mod constants;
mod joint;
#[cfg(test)]
mod tests;

pub use constants::{
    CATCH_NM_S, CORRECTION_SHARE, END_RAD, FADE_RAD, FIRM_SHARE, FRICTION_RATIO, FRICTION_SHARE,
    HELD_RATIO, LIGHT_DRY_SHARE, LIGHT_SHARE, MOTOR_RATIO, PERIOD_MAX_US, REACH_RAD, REST_RAD_S,
    REST_S, TRANSFER_PER_S,
};

pub use crate::arm::{Parameters, Posture, State};
use crate::real::Real;
use armbridge_servo::JOINTS;
use joint::{FloatJoint, JointState, Timing};
use nalgebra::Vector2;

/// Parameters of both joints for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Float<T> {
    joints: [FloatJoint<T>; JOINTS],
    timing: Timing<T>,
}

/// Memory of both joints between two ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FloatState<T> {
    joints: [JointState<T>; JOINTS],
}

/// Torques of a tick, in N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatTorque<T> {
    /// For the motors.
    pub torque_nm: Vector2<T>,
    /// For an estimator without knowledge of hand, friction and errors of the model: the torque
    /// under which the model goes on with its speed.
    pub balanced_nm: Vector2<T>,
}

impl<T: Real> Float<T> {
    /// For this arm, with this dry friction in N m, sampled every `period_s`.
    pub fn new(arm: &Parameters<T>, dry_nm: [T; JOINTS], period_s: T) -> Self {
        let [weight_1, weight_2] = arm.weight_nm();
        let [dry_1, dry_2] = dry_nm;
        Self {
            joints: [
                FloatJoint::new(weight_1, dry_1, arm.b1),
                FloatJoint::new(weight_2, dry_2, arm.b2),
            ],
            timing: Timing::new(period_s),
        }
    }

    /// Begins with the arm in this state, held by `torque_nm` until now, if it is: what that
    /// is beyond the model's gravity is trim.
    pub fn begin(
        &self,
        arm: &Parameters<T>,
        state: &State<T>,
        torque_nm: Option<Vector2<T>>,
    ) -> FloatState<T> {
        let gravity_nm = Posture::of(state.q).gravity(arm);
        let beyond_nm = torque_nm.map_or_else(Vector2::zeros, |torque_nm| torque_nm - gravity_nm);
        let joints = core::array::from_fn(|joint| {
            self.joints[joint].begin(&self.timing, state.q[joint], beyond_nm[joint])
        });
        FloatState { joints }
    }

    /// The torques for an arm that will be in `state` when they act.
    pub fn torque(
        &self,
        memory: &mut FloatState<T>,
        arm: &Parameters<T>,
        state: &State<T>,
    ) -> FloatTorque<T> {
        let gravity_nm = Posture::of(state.q).gravity(arm);
        let ([a, b], [joint_a, joint_b]) = (&mut memory.joints, &self.joints);
        let torque_nm = Vector2::new(
            joint_a.torque(&self.timing, a, gravity_nm.x, state.q.x),
            joint_b.torque(&self.timing, b, gravity_nm.y, state.q.y),
        );
        FloatTorque {
            torque_nm,
            balanced_nm: gravity_nm + arm.viscous_torque(state.dq),
        }
    }
}
