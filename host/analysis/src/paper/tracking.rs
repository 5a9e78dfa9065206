//! Trajectory tracking by computed torque.
//!
//! The paper tracks "with nonlinear control" and prints neither the law nor the
//! trajectory. This is the textbook's law for a model like (1),
//!
//! ```text
//! torque = M(q) (ddq_d + kd (dq_d - dq) + kp (q_d - q)) + (Co + F) dq + G(q)
//! ```
//!
//! with both error poles at `-omega`: kp = omega^2, kd = 2 omega. The board's own,
//! [`ComputedTorque`](armbridge_shared::control::ComputedTorque), is the same but
//! for refusing what cannot be stable at its period, which is what is tried here.

use core::f64::consts::TAU;

use armbridge_shared::JOINTS;
use armbridge_shared::arm::{Parameters, Posture, State};
use nalgebra::Vector2;

/// Amplitude in rad and frequency in Hz of each joint's sine.
pub(crate) const SINE: [(f64, f64); JOINTS] = [(0.4, 0.25), (0.5, 0.30)];

/// Time in s over which the sines swell, so that the motion starts at rest.
pub(crate) const SWELL_S: f64 = 2.0;

/// Where the arm shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    pub(crate) q: Vector2<f64>,
    pub(crate) dq: Vector2<f64>,
    pub(crate) ddq: Vector2<f64>,
}

/// The desired motion at a time: a sine on each joint, swelling from rest.
pub(crate) fn goal(time_s: f64) -> Goal {
    // 10 s^3 - 15 s^4 + 6 s^5: no jump in speed or acceleration at either end.
    let s = (time_s / SWELL_S).clamp(0.0, 1.0);
    let swell = s.powi(3) * (10.0 + s * (6.0 * s - 15.0));
    let d_swell = 30.0 * (s * (1.0 - s)).powi(2) / SWELL_S;
    let dd_swell = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / SWELL_S.powi(2);
    let joint = |(amplitude, hertz): (f64, f64)| {
        let w = TAU * hertz;
        let (sin, cos) = (w * time_s).sin_cos();
        [
            amplitude * swell * sin,
            amplitude * (d_swell * sin + swell * w * cos),
            amplitude * (dd_swell * sin + 2.0 * d_swell * w * cos - swell * w * w * sin),
        ]
    };
    let [first, second] = SINE.map(joint);
    let both = |i: usize| Vector2::new(first[i], second[i]);
    Goal {
        q: both(0),
        dq: both(1),
        ddq: both(2),
    }
}

/// The law above: torque in N m for a state and a goal.
pub(crate) fn computed_torque(
    arm: &Parameters<f64>,
    omega: f64,
    state: &State<f64>,
    goal: &Goal,
) -> Vector2<f64> {
    let State { q, dq } = *state;
    let wanted = goal.ddq + (goal.dq - dq) * (2.0 * omega) + (goal.q - q) * (omega * omega);
    Posture::of(q).inverse_dynamics(arm, dq, wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_and_accelerations_are_derivatives() {
        let h = 1e-5;
        for time_s in [0.1, 0.9, 1.7, 2.5, 7.3] {
            let (before, now, after) = (goal(time_s - h), goal(time_s), goal(time_s + h));
            let dq = (after.q - before.q) / (2.0 * h);
            let ddq = (after.dq - before.dq) / (2.0 * h);
            assert!((dq - now.dq).amax() < 1e-8 && (ddq - now.ddq).amax() < 1e-8);
        }
        assert!(goal(0.0).dq.amax() + goal(0.0).q.amax() < 1e-15);
    }

    #[test]
    fn the_law_makes_the_error_linear() {
        let arm = Parameters::paper();
        let state = State {
            q: Vector2::new(0.3, -0.6),
            dq: Vector2::new(1.2, -0.8),
        };
        let goal = goal(1.3);
        let torque = computed_torque(&arm, 9.0, &state, &goal);
        let wanted = goal.ddq + (goal.dq - state.dq) * 18.0 + (goal.q - state.q) * 81.0;
        assert!((arm.acceleration(&state, torque) - wanted).amax() < 1e-10);
    }
}
