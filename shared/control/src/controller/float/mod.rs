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
//! the friction (Prandtl's element). It holds without creep, and needs no estimated speed: `v` is
//! the speed of the slip. It gives back what its spring has stored and no more.
//!
//! | joint                             | strength                                            |
//! |-----------------------------------|-----------------------------------------------------|
//! | at rest, not yet weighed          | firm: [`FIRM_SHARE`] of its weight                  |
//! | at rest, weighed                  | [`HELD_RATIO`] times light                          |
//! | in motion                         | light: [`LIGHT_SHARE`] of its weight, or [`LIGHT_DRY_SHARE`] of its dry friction, if that is more |
//! | beyond [`END_RAD`], moving outward | firm                                               |
//!
//! # Weighing
//!
//! A joint rests when it has slipped slower than [`REST_RAD_S`] for [`REST_S`]. The load of `F` is
//! then taken over at a rate of [`TRANSFER_PER_S`]: anchor and torques change together, so that
//! their sum stays what it is, and nothing moves. Part of the load becomes the scale `s` of the
//! joint's gravity, which goes with the arm wherever it is led; the rest is the trim `t` of this
//! place, which fades over [`FADE_RAD`] of the motion that it drives. Both together are at most
//! [`CORRECTION_SHARE`] of the joint's weight. The load of a hand that holds the arm at rest is
//! taken over, too, and fades in the same way.
//!
//! In motion the trim grows against the slip by [`CATCH_NM_S`]: an error of the weight that dry
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
//! An arm that is a fifth heavier than the model stays where it leans:
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
//! for _ in 0..3_000 {
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

use constants::{
    ANGLE_S, BRAKE_NM, BRAKE_NM_S, BRAKE_RAD_S, END_PER_S, SLIDE_RAD_S, SPEED_S, STRENGTH_S,
    VISCOUS_MIN_NM_S, VISCOUS_RAD_S, WEIGH_S, WEIGHT_MIN_NM,
};
use joint::JointState;

use crate::arm::{Parameters, Posture, State};
use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Parameters of both joints for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Float<T> {
    /// Largest gravity torque of each joint in N m.
    weight_nm: [T; JOINTS],
    /// Strength of the light friction in N m.
    light_nm: [T; JOINTS],
    /// Dry friction that is compensated, in N m, and viscous friction, in N m s/rad.
    dry_nm: [T; JOINTS],
    viscous_nm_s: [T; JOINTS],
    /// Speed in rad/s beyond which no more viscous friction is compensated.
    viscous_rad_s: [T; JOINTS],
    period_s: T,
    /// Share of a tick in the smoothed angle, in the smoothed speed and in the strength.
    angle_share: T,
    speed_share: T,
    strengthening: T,
    rest_ticks: u32,
    weighed_ticks: u32,
}

checked!(Float<T> {
    weight_nm, light_nm, dry_nm, viscous_nm_s, viscous_rad_s, period_s, angle_share, speed_share, strengthening, rest_ticks,
    weighed_ticks,
});

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
        let share = T::lit(FRICTION_SHARE);
        let ticks = |seconds: f64| -> u32 {
            let ticks = T::lit(seconds) / period_s;
            u32::from(ticks.to_count()).max(1)
        };
        let lag = |seconds: f64| period_s / (period_s + T::lit(seconds));
        let weight_nm = arm.weight_nm().map(|nm| nm.max(T::lit(WEIGHT_MIN_NM)));
        let viscous = [arm.b1, arm.b2];
        let light_nm = core::array::from_fn(|joint| {
            let of_dry_nm = dry_nm[joint] * T::lit(LIGHT_DRY_SHARE);
            (weight_nm[joint] * T::lit(LIGHT_SHARE)).max(of_dry_nm)
        });
        let viscous_rad_s = core::array::from_fn(|joint| {
            // The compensation exceeds the true friction by the light friction there.
            let allowed_nm =
                light_nm[joint] / T::lit(FRICTION_SHARE * MOTOR_RATIO - FRICTION_RATIO);
            let rad_s = (allowed_nm - dry_nm[joint]) / viscous[joint].max(T::lit(VISCOUS_MIN_NM_S));
            rad_s.clamp(T::zero(), T::lit(VISCOUS_RAD_S))
        });
        Self {
            weight_nm,
            light_nm,
            dry_nm: dry_nm.map(|nm| nm * share),
            viscous_nm_s: viscous.map(|nm_s| nm_s * share),
            viscous_rad_s,
            period_s,
            angle_share: lag(ANGLE_S),
            speed_share: lag(SPEED_S),
            strengthening: lag(STRENGTH_S),
            rest_ticks: ticks(REST_S),
            weighed_ticks: ticks(REST_S + WEIGH_S),
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
            let most_nm = self.weight_nm[joint] * T::lit(CORRECTION_SHARE);
            JointState {
                angle_rad: state.q[joint],
                anchor_rad: state.q[joint],
                strength_nm: self.weight_nm[joint] * T::lit(FIRM_SHARE),
                scale: T::zero(),
                trim_nm: beyond_nm[joint].clamp(-most_nm, most_nm),
                speed_rad_s: T::zero(),
                slow_ticks: self.rest_ticks,
                is_weighed: false,
            }
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
        let [a, b] = &mut memory.joints;
        let torque_nm = Vector2::new(
            self.joint_torque(0, a, gravity_nm.x, state.q.x),
            self.joint_torque(1, b, gravity_nm.y, state.q.y),
        );
        FloatTorque {
            torque_nm,
            balanced_nm: gravity_nm + arm.viscous_torque(state.dq),
        }
    }

    /// The torque of one joint, in N m.
    fn joint_torque(
        &self,
        joint: usize,
        memory: &mut JointState<T>,
        gravity_nm: T,
        angle_rad: T,
    ) -> T {
        memory.angle_rad += (angle_rad - memory.angle_rad) * self.angle_share;
        let angle_rad = memory.angle_rad;
        let weight_nm = self.weight_nm[joint];
        let light_nm = self.light_nm[joint];
        let stiffness = light_nm / T::lit(REACH_RAD);
        let stretch_nm = stiffness * (memory.anchor_rad - angle_rad);
        let end = T::lit(END_RAD);
        let firm_nm = (weight_nm * T::lit(FIRM_SHARE)).max(memory.strength_nm);
        let strength_nm = |is_beyond| {
            if is_beyond {
                firm_nm
            } else {
                memory.strength_nm
            }
        };
        let mut load_nm =
            stretch_nm.clamp(-strength_nm(angle_rad > end), strength_nm(angle_rad < -end));
        memory.note_slip(self, (load_nm - stretch_nm) / stiffness);
        memory.strengthen(self, weight_nm, light_nm);
        load_nm -= memory.weigh(self, joint, gravity_nm, load_nm);
        memory.anchor_rad = angle_rad + load_nm / stiffness;
        let friction_nm = self.friction(joint, memory.speed_rad_s);
        let correction_nm = gravity_nm * memory.scale + memory.trim_nm;
        gravity_nm + correction_nm + load_nm + friction_nm - brake(angle_rad, memory.speed_rad_s)
    }

    /// Compensation of the model's friction in N m at this speed.
    fn friction(&self, joint: usize, speed_rad_s: T) -> T {
        let one = T::one();
        let sliding = (speed_rad_s / T::lit(SLIDE_RAD_S)).clamp(-one, one);
        let fastest = self.viscous_rad_s[joint];
        let viscous_rad_s = speed_rad_s.clamp(-fastest, fastest);
        self.dry_nm[joint] * sliding + self.viscous_nm_s[joint] * viscous_rad_s
    }
}

/// Torque in N m that brakes a joint: beyond [`BRAKE_RAD_S`], and on its way to [`END_RAD`].
fn brake<T: Real>(angle_rad: T, speed_rad_s: T) -> T {
    let (fastest, end, near) = (T::lit(BRAKE_RAD_S), T::lit(END_RAD), T::lit(END_PER_S));
    let free = |room_rad: T| (near * room_rad).clamp(T::zero(), fastest);
    let excess = speed_rad_s - speed_rad_s.clamp(-free(end + angle_rad), free(end - angle_rad));
    (excess * T::lit(BRAKE_NM_S)).clamp(-T::lit(BRAKE_NM), T::lit(BRAKE_NM))
}
