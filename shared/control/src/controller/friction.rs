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

use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// The feed-forward, for both joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryFriction<T> {
    /// Largest compensation in N m, joint by joint.
    pub torque_nm: [T; JOINTS],
    /// Feedback torque in N m from which on, at rest, all of it is.
    pub blend_nm: T,
    /// Reference speed in rad/s from which on all of it is.
    pub slide_rad_s: T,
}

checked!(DryFriction<T> { torque_nm, blend_nm, slide_rad_s });

impl<T: Real> DryFriction<T> {
    /// For this much friction, blended in over 20 mN m, nearly twice what sensor
    /// noise makes of a torque at rest, and 0.05 rad/s.
    pub fn of(torque_nm: [T; JOINTS]) -> Self {
        Self {
            torque_nm,
            blend_nm: T::lit(0.02),
            slide_rad_s: T::lit(0.05),
        }
    }

    /// Friction compensation in N m for a torque of which `feedback_nm` corrects errors, and
    /// a reference that moves at `speed_rad_s`.
    pub fn feed_forward(&self, feedback_nm: Vector2<T>, speed_rad_s: Vector2<T>) -> Vector2<T> {
        let drive = feedback_nm / self.blend_nm + speed_rad_s / self.slide_rad_s;
        let one = T::one();
        drive
            .map(|drive| drive.clamp(-one, one))
            .component_mul(&Vector2::from(self.torque_nm))
    }
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
}
