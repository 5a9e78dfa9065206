//! Feed-forward compensation of dry friction.
//!
//! The paper finds no motion for 950 < PWM < 1050: 50 counts, 0.06 N m, of static
//! friction, and rests tens of milliradians off for it. What a motor adds against
//! friction must point where the arm is about to go, and there are two signs of
//! that: the speed it is asked for, and, at rest, the torque by which the feedback
//! pulls. Friction opposes motion, not torque: added in the direction of the whole
//! torque it would push an arm that hangs to one side further out.
//!
//! ```text
//! drive = feedback / blend + dq_r / slide
//! added = fc drive        for |drive| < 1, fc sign(drive) beyond
//! ```
//!
//! The ramp through zero is there because a step would make noise rattle the servo
//! by twice fc. A blend well above the feedback's noise keeps it quiet.
//!
//! # Load on the gears
//!
//! Friction of loaded gears grows with the torque that they transmit: that of the motor and that
//! of the load, which press upon the same teeth ([`gear_torque`]). The compensation is part of the
//! motor's torque, so it follows from an equation with itself on both sides, whose solution is
//! piecewise linear:
//!
//! ```text
//! f = fc + load |gears + f|         gears: without the compensation, positive as f
//! f = (fc + load gears) / (1 - load)        for gears + fc >= 0
//! f = (fc - load gears) / (1 + load)        else
//! ```
//!
//! It may be several times fc. Its ramp through zero is no steeper than that of
//! [`STEEPEST_NM`]: a steeper one would be a gain of the loop for which nothing was designed.

use crate::arm::{Parameters, Posture, State};
use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Largest load friction in N m per N m: half of the torque is lost, and the compensation doubles
/// what it is added to. An XL330 has 0.17.
pub const LOAD_MAX: f64 = 0.5;
/// Coulomb friction in N m whose ramp is the steepest: static friction of the paper's arm, the
/// most that is compensated without load.
pub const STEEPEST_NM: f64 = 0.06;

/// The feed-forward, for both joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryFriction<T> {
    /// Largest compensation in N m without load on the gears, joint by joint.
    pub torque_nm: [T; JOINTS],
    /// Feedback torque in N m from which on, at rest, all of it is.
    pub blend_nm: T,
    /// Reference speed in rad/s from which on all of it is.
    pub slide_rad_s: T,
    /// Friction in N m per N m on the gears, joint by joint, at most [`LOAD_MAX`]; `None` for gears
    /// whose friction does not depend on it.
    pub load: Option<[T; JOINTS]>,
}

checked!(DryFriction<T> { torque_nm, blend_nm, slide_rad_s, load });

impl<T: Real> DryFriction<T> {
    /// For this much friction, blended in over 20 mN m, nearly twice what sensor
    /// noise makes of a torque at rest, and 0.05 rad/s.
    pub fn of(torque_nm: [T; JOINTS]) -> Self {
        Self {
            torque_nm,
            blend_nm: T::lit(0.02),
            slide_rad_s: T::lit(0.05),
            load: None,
        }
    }

    /// The same with friction that grows with the load on the gears, if it does.
    #[must_use]
    pub fn with_load(self, load: [T; JOINTS]) -> Self {
        let has_load = load.iter().any(|load| *load > T::zero());
        Self {
            load: has_load.then_some(load),
            ..self
        }
    }

    /// Friction compensation in N m for a torque of which `feedback_nm` corrects errors, and
    /// a reference that moves at `speed_rad_s`; of gears without load.
    pub fn feed_forward(&self, feedback_nm: Vector2<T>, speed_rad_s: Vector2<T>) -> Vector2<T> {
        let one = T::one();
        self.drive(feedback_nm, speed_rad_s)
            .map(|drive| drive.clamp(-one, one))
            .component_mul(&Vector2::from(self.torque_nm))
    }

    /// The same of gears with this load friction, which transmit `gears_nm` beside the
    /// compensation.
    pub fn loaded_feed_forward(
        &self,
        feedback_nm: Vector2<T>,
        speed_rad_s: Vector2<T>,
        load: [T; JOINTS],
        gears_nm: Vector2<T>,
    ) -> Vector2<T> {
        let drive = self.drive(feedback_nm, speed_rad_s);
        let ([coulomb_1, coulomb_2], [load_1, load_2]) = (self.torque_nm, load);
        Vector2::new(
            loaded(drive.x, coulomb_1, load_1, gears_nm.x),
            loaded(drive.y, coulomb_2, load_2, gears_nm.y),
        )
    }

    fn drive(&self, feedback_nm: Vector2<T>, speed_rad_s: Vector2<T>) -> Vector2<T> {
        feedback_nm / self.blend_nm + speed_rad_s / self.slide_rad_s
    }
}

/// Torque in N m that the gears transmit while the motors give `motor_nm` at rest: what is left of
/// it after viscous friction, which is nearly all back-EMF, and the torque that holds the arm.
///
/// No acceleration is in it, so that friction follows from it without an equation to solve.
pub fn gear_torque<T: Real>(
    arm: &Parameters<T>,
    posture: &Posture<T>,
    state: &State<T>,
    motor_nm: Vector2<T>,
) -> Vector2<T> {
    motor_nm - arm.viscous_torque(state.dq) + posture.gravity(arm)
}

/// Compensation of one joint, see the [module](self).
fn loaded<T: Real>(drive: T, coulomb_nm: T, load: T, gears_nm: T) -> T {
    let one = T::one();
    let towards = if drive < T::zero() {
        -gears_nm
    } else {
        gears_nm
    };
    let most = if towards + coulomb_nm >= T::zero() {
        (coulomb_nm + load * towards) / (one - load)
    } else {
        (coulomb_nm - load * towards) / (one + load)
    };
    let steepest = T::lit(STEEPEST_NM);
    let ramp = if most > steepest { steepest } else { most };
    (drive * ramp).clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_pull_at_rest_and_the_motion_otherwise() {
        let friction = DryFriction::of([0.04_f32, 0.06]);
        let added = |feedback: f32, speed: f32| {
            friction.feed_forward(Vector2::repeat(feedback), Vector2::repeat(speed))
        };
        assert_eq!(added(0.0, 0.0), Vector2::zeros());
        assert_eq!(added(0.5, 0.0), Vector2::new(0.04, 0.06));
        assert_eq!(added(-0.01, 0.0), Vector2::new(-0.02, -0.03));
        // Braked in mid motion, it still slides forward.
        assert_eq!(added(-0.02, 1.0), Vector2::new(0.04, 0.06));
        assert!(added(f32::NAN, 0.0).iter().all(|x| x.is_nan()));
    }

    #[test]
    fn full_compensation_is_the_friction_of_the_torque_with_it() {
        let coulomb_nm = 0.01;
        for load in [0.0, 0.17, LOAD_MAX] {
            for step in -100..=100 {
                let gears_nm = f64::from(step) * 0.01;
                for direction in [1.0, -1.0] {
                    let added_nm = loaded(1e6 * direction, coulomb_nm, load, gears_nm);
                    let friction_nm = coulomb_nm + load * (gears_nm + added_nm).abs();
                    let off = added_nm - friction_nm * direction;
                    assert!(off.abs() < 1e-12, "{load}, {gears_nm} N m: {off:e}");
                }
            }
        }
    }

    #[test]
    fn a_loaded_ramp_begins_at_zero_and_is_no_steeper_than_another() {
        let at = |drive: f64| loaded(drive, 0.01, 0.17, 0.5);
        let most_nm = (0.01 + 0.17 * 0.5) / 0.83;
        assert!(at(0.0).abs() <= 0.0);
        assert!((at(0.1) - 0.1 * STEEPEST_NM).abs() < 1e-15);
        assert!((at(-0.1) + 0.1 * STEEPEST_NM).abs() < 1e-15);
        assert!((at(2.0) - most_nm).abs() < 1e-15, "{}", at(2.0));
        // Where the load helps, there is less to compensate.
        assert!((at(-2.0) + (0.17 * 0.5 - 0.01) / 1.17 + 0.02 / 1.17).abs() < 1e-15);
        assert!(at(f64::NAN).is_nan());
    }

    #[test]
    fn without_load_it_is_the_compensation_of_gears_without() {
        let friction = DryFriction::of([0.04_f32, 0.06]);
        assert_eq!(friction.with_load([0.0; JOINTS]), friction);
        for step in -30..=30_i16 {
            let feedback_nm = Vector2::repeat(f32::from(step) * 1e-3);
            let speed_rad_s = Vector2::new(0.0, 0.01);
            let gears_nm = Vector2::new(0.5, -0.5);
            let plain = friction.feed_forward(feedback_nm, speed_rad_s);
            let loaded =
                friction.loaded_feed_forward(feedback_nm, speed_rad_s, [0.0; JOINTS], gears_nm);
            assert!((plain - loaded).amax() < 1e-8, "{plain} {loaded}");
        }
    }
}
