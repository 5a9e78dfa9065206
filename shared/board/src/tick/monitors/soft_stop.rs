//! Soft stop: bounds of the torque within which no joint reaches its angle limit.
//!
//! Each joint may go as fast towards a limit as it can still be stopped from,
//! [`MARGIN_RAD`] before it. With `d` the remaining distance and `v` the
//! speed towards the limit, that is
//!
//! ```text
//! v <= near d                          slowly: as a first-order lag ends
//! v^2 <= 2 a (d - a/(2 near^2))        faster than a/near: braked by a
//! ```
//!
//! two curves that touch where they meet. A control barrier function keeps the joint below them: the
//! acceleration towards the limit is at most
//!
//! ```text
//! A = near back d - (near + back) v                          slow
//! A = -a + back (2 a d - (a/near)^2 - v^2) / (2 v)           fast
//! ```
//!
//! with which the margin below the curve decays at the rate `back` at most,
//! and an excess above it at that rate at least. A is continuous in d and v, so the
//! torque is; close to the end it is that of a spring and a damper with the real
//! poles `near` and `back`. So a joint that is pushed against the end comes to
//! rest there and is held.
//!
//! Equation (1) converts accelerations to torques. The bounds do not include
//! the limits of the servos: a joint that is too fast for full torque goes beyond.

use crate::tick::limits::MOTION;
use armbridge_control::arm::{Parameters, Posture, State};
use armbridge_control::check_word::checked;
use armbridge_link::limits::SOFT_STOP_RAD;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Distance before the limit at which a joint is stopped: 20 encoder counts, for lag of the
/// estimate and speeds that full torque is slow to brake.
const MARGIN_RAD: f32 = SOFT_STOP_RAD;

/// Largest fraction of an angle limit that this margin takes: a narrow limit must leave a
/// range.
const MARGIN_SHARE: f32 = 0.25;

/// Deceleration in rad/s^2: the bound of any motion, so that no motion within its bounds is
/// braked.
const BRAKE_RAD_S2: f32 = MOTION.acceleration_rad_s2;

/// Rates in 1/s: slower than the estimate of a speed, which takes 15 ms, and fast
/// enough that no motion within its bounds is braked.
const NEAR_1_S: f32 = 10.0;
const BACK_1_S: f32 = 20.0;

/// Largest decay of `back` within a period, and twice that of `near`: beyond
/// 1 it would overshoot in every tick. Reached at periods above 40 ms.
const DECAY_MAX: f32 = 0.8;

/// Acceleration in rad/s^2 above which a bound has no effect, three times that of full
/// torque on the lighter joint: the arm's equations are not evaluated there.
const FREE_RAD_S2: f32 = 150.0;

/// Least and most torque of one joint in N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) low_nm: f32,
    pub(super) high_nm: f32,
    /// Magnitude of the angle of the joint.
    pub(super) angle_rad: f32,
    /// Angle at which the joint is stopped.
    pub(super) stop_rad: f32,
}

impl Bounds {
    /// No bounds.
    pub(super) const FREE: Self = Self {
        low_nm: f32::NEG_INFINITY,
        high_nm: f32::INFINITY,
        angle_rad: 0.0,
        stop_rad: 0.0,
    };
}

/// Coefficients of the curves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SoftStop {
    stop_rad: [f32; JOINTS],
    /// `near back`, in 1/s^2.
    stiffness: f32,
    /// `near + back`, in 1/s.
    damping: f32,
    /// `a/near`, in rad/s, and its square.
    slow_rad_s: f32,
    slow_squared: f32,
    /// Half of `back`.
    half_back: f32,
}

checked!(SoftStop {
    stop_rad,
    stiffness,
    damping,
    slow_rad_s,
    slow_squared,
    half_back,
});

impl SoftStop {
    pub(super) fn new(angle_rad: [f32; JOINTS], period_us: u32) -> Self {
        let back = BACK_1_S.min(DECAY_MAX / (period_us as f32 * 1e-6));
        let near = NEAR_1_S.min(back * 0.5);
        let slow_rad_s = BRAKE_RAD_S2 / near;
        Self {
            stop_rad: angle_rad.map(|angle| angle - MARGIN_RAD.min(angle * MARGIN_SHARE)),
            stiffness: near * back,
            damping: near + back,
            slow_rad_s,
            slow_squared: slow_rad_s * slow_rad_s,
            half_back: back * 0.5,
        }
    }

    /// Bounds for an arm that is at `state` when the torque begins to act; `None`
    /// where they have no effect.
    pub(super) fn bounds(
        &self,
        arm: &Parameters<f32>,
        state: &State<f32>,
    ) -> Option<[Bounds; JOINTS]> {
        let [stop_a, stop_b] = self.stop_rad;
        let ([q_a, q_b], [dq_a, dq_b]) = (state.q.into(), state.dq.into());
        // Towards the nearer stop at that speed: a lower bound of the room.
        let room_a = self.acceleration_limit(stop_a - q_a.abs(), dq_a.abs());
        let room_b = self.acceleration_limit(stop_b - q_b.abs(), dq_b.abs());
        if room_a > FREE_RAD_S2 && room_b > FREE_RAD_S2 {
            return None;
        }
        let up = Vector2::new(
            self.acceleration_limit(stop_a - q_a, dq_a),
            self.acceleration_limit(stop_b - q_b, dq_b),
        );
        let down = Vector2::new(
            self.acceleration_limit(stop_a + q_a, -dq_a),
            self.acceleration_limit(stop_b + q_b, -dq_b),
        );
        let posture = Posture::of(state.q);
        let mass = posture.mass_diagonal(arm);
        let steady = posture.inverse_dynamics(arm, state.dq, Vector2::zeros());
        let high = steady + mass.component_mul(&up);
        let low = steady - mass.component_mul(&down);
        let bounds = |stop_rad: f32, angle_rad: f32, low_nm: f32, high_nm: f32| Bounds {
            low_nm,
            high_nm,
            angle_rad: angle_rad.abs(),
            stop_rad,
        };
        Some([
            bounds(stop_a, q_a, low.x, high.x),
            bounds(stop_b, q_b, low.y, high.y),
        ])
    }

    /// The farthest angle in rad at which a joint with this speed is not braked: where the
    /// acceleration limit is 0.
    pub(super) fn farthest_rad(&self, joint: usize, speed_rad_s: f32) -> f32 {
        let left_rad = if speed_rad_s <= self.slow_rad_s {
            self.damping * speed_rad_s / self.stiffness
        } else {
            let below = BRAKE_RAD_S2 * speed_rad_s / self.half_back;
            (below + self.slow_squared + speed_rad_s * speed_rad_s) / (2.0 * BRAKE_RAD_S2)
        };
        self.stop_rad.get(joint).map_or(0.0, |stop| stop - left_rad)
    }

    /// Largest acceleration in rad/s^2 towards a stop that is `left_rad` away, at a speed
    /// towards it.
    fn acceleration_limit(&self, left_rad: f32, speed_rad_s: f32) -> f32 {
        if speed_rad_s <= self.slow_rad_s {
            self.stiffness * left_rad - self.damping * speed_rad_s
        } else {
            let below =
                2.0 * BRAKE_RAD_S2 * left_rad - self.slow_squared - speed_rad_s * speed_rad_s;
            self.half_back * below / speed_rad_s - BRAKE_RAD_S2
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_far_as_nothing_is_slowed() {
        let stop = SoftStop::new([1.5, 1.0], 1_000);
        for (joint, stop_rad) in [(0, 1.4), (1, 0.9)] {
            for speed in [0.0, 0.5, 1.0, 2.0, 2.001, 4.0, 10.0] {
                let left = stop_rad - stop.farthest_rad(joint, speed);
                assert!(
                    stop.acceleration_limit(left, speed).abs() < 1e-3,
                    "{joint} {speed}"
                );
                assert!(
                    stop.acceleration_limit(left - 0.01, speed) < 0.0
                        && stop.acceleration_limit(left + 0.01, speed) > 0.0
                );
            }
        }
    }

    #[test]
    fn the_two_curves_are_one() {
        for period_us in [600, 1_000, 45_000, 100_000] {
            let stop = SoftStop::new([1.5; JOINTS], period_us);
            for step in -20..=40_i16 {
                let left = f32::from(step) * 0.05;
                let slow = stop.acceleration_limit(left, stop.slow_rad_s);
                let fast = stop.acceleration_limit(left, stop.slow_rad_s * 1.0001);
                assert!((slow - fast).abs() < 0.05, "{left}: {slow} {fast}");
            }
        }
    }
}
