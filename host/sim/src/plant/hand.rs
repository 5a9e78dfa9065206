//! A hand that guides the arm: both joints move to given angles, and are held there.
//!
//! The hand is stiff: it imposes the motion, whatever torques act. Each joint follows the
//! quintic of least jerk from its angle and speed at the start, without acceleration, to rest
//! at the target. A hand that begins with an arm at rest moves it along
//! `q0 + (q1 - q0) (10 s^3 - 15 s^4 + 6 s^5)` with `s` from 0 to 1, whose speed peaks at
//! 1.875 times the mean.

use armbridge_control::arm::State;
use nalgebra::Vector2;

/// A motion of a hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hand {
    from: State<f64>,
    to_rad: Vector2<f64>,
    start_ns: u64,
    duration_ns: u64,
}

impl Hand {
    /// Holds the arm at rest at these angles.
    pub(super) fn holding(at_rad: Vector2<f64>) -> Self {
        Self::moving(0, State::at_rest(at_rad), at_rad, 0)
    }

    /// Grasps the arm at `start_ns` in this state.
    pub(super) fn moving(
        start_ns: u64,
        from: State<f64>,
        to_rad: Vector2<f64>,
        duration_ns: u64,
    ) -> Self {
        Self {
            from,
            to_rad,
            start_ns,
            duration_ns,
        }
    }

    /// Angles and speeds at `at_ns`.
    pub(super) fn state(&self, at_ns: u64) -> State<f64> {
        let elapsed_ns = at_ns.saturating_sub(self.start_ns);
        if elapsed_ns >= self.duration_ns {
            return State::at_rest(self.to_rad);
        }
        let duration_s = self.duration_ns as f64 * 1e-9;
        let s = elapsed_ns as f64 / self.duration_ns as f64;
        let (way, speed) = (self.to_rad - self.from.q, self.from.dq * duration_s);
        // Quintics with these ends: 0 to 1 at rest, and from 0 with slope 1 back to 0.
        let step = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let swing = s - s * s * s * (6.0 + s * (3.0 * s - 8.0));
        let step_slope = 30.0 * s * s * (1.0 - s) * (1.0 - s);
        let swing_slope = 1.0 - s * s * (18.0 + s * (15.0 * s - 32.0));
        State {
            q: self.from.q + way * step + speed * swing,
            dq: (way * step_slope + speed * swing_slope) / duration_s,
        }
    }

    /// Whether it has arrived.
    pub(super) fn is_still(&self, at_ns: u64) -> bool {
        at_ns.saturating_sub(self.start_ns) >= self.duration_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falling_arm_is_caught_without_a_jump() {
        let from = State {
            q: Vector2::new(0.5, -0.2),
            dq: Vector2::new(2.0, -1.0),
        };
        let to_rad = Vector2::new(-0.3, 0.4);
        let hand = Hand::moving(1_000, from, to_rad, 1_500_000_000);
        let (mut last, mut peak) = (hand.state(1_000), 0.0_f64);
        assert!((last.q - from.q).norm() < 1e-12 && (last.dq - from.dq).norm() < 1e-12);
        for ms in 1..=1_500_u64 {
            let state = hand.state(1_000 + ms * 1_000_000);
            // The speed is the slope of the angle.
            let slope = (state.q - last.q) / 1e-3;
            let mean = (state.dq + last.dq) / 2.0;
            assert!((slope - mean).norm() < 1e-4, "{ms} ms: {slope} {mean}");
            peak = peak.max(state.dq.amax());
            last = state;
        }
        assert_eq!(last, State::at_rest(to_rad));
        assert!(hand.is_still(1_500_001_000) && peak < 3.0, "{peak} rad/s");
    }
}
