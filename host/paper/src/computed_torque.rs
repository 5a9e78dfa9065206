//! Trajectory tracking by computed torque.
//!
//! The paper tracks "with nonlinear control" and prints neither the law nor the
//! trajectory. This is the textbook law for a model like (1),
//!
//! ```text
//! torque = M(q) (ddq_d + kd (dq_d - dq) + kp (q_d - q)) + (Co + F) dq + G(q)
//! ```
//!
//! with both error poles at `-omega`: kp = omega^2, kd = 2 omega. The board's law,
//! [`ComputedTorque`](armbridge_control::controller::ComputedTorque), is the same but
//! rejects gains that cannot be stable at its period; here such gains are tried.

use core::f64::consts::TAU;

use armbridge_control::arm::{Parameters, Posture, State};
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Amplitude in rad and frequency in Hz of each joint's sine.
pub(crate) const SINE: [(f64, f64); JOINTS] = [(0.4, 0.25), (0.5, 0.30)];

/// Time in s over which the amplitudes grow from 0, so that the motion starts at rest.
pub(crate) const RAMP_S: f64 = 2.0;

/// Reference of a trajectory at one time: angles, speeds and accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reference {
    pub(crate) q: Vector2<f64>,
    pub(crate) dq: Vector2<f64>,
    pub(crate) ddq: Vector2<f64>,
}

/// Reference at a time: a sine on each joint whose amplitude grows from rest.
pub(crate) fn reference(time_s: f64) -> Reference {
    // 10 s^3 - 15 s^4 + 6 s^5: no jump in speed or acceleration at either end.
    let s = (time_s / RAMP_S).clamp(0.0, 1.0);
    let ramp = s.powi(3) * (10.0 + s * (6.0 * s - 15.0));
    let d_ramp = 30.0 * (s * (1.0 - s)).powi(2) / RAMP_S;
    let dd_ramp = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / RAMP_S.powi(2);
    let joint = |(amplitude, hertz): (f64, f64)| {
        let w = TAU * hertz;
        let (sin, cos) = (w * time_s).sin_cos();
        [
            amplitude * ramp * sin,
            amplitude * (d_ramp * sin + ramp * w * cos),
            amplitude * (dd_ramp * sin + 2.0 * d_ramp * w * cos - ramp * w * w * sin),
        ]
    };
    let [first, second] = SINE.map(joint);
    let both = |i: usize| Vector2::new(first[i], second[i]);
    Reference {
        q: both(0),
        dq: both(1),
        ddq: both(2),
    }
}

/// The law above: torque in N m for a state and a reference.
pub(crate) fn computed_torque(
    arm: &Parameters<f64>,
    omega: f64,
    state: &State<f64>,
    reference: &Reference,
) -> Vector2<f64> {
    let State { q, dq } = *state;
    let ddq =
        reference.ddq + (reference.dq - dq) * (2.0 * omega) + (reference.q - q) * (omega * omega);
    Posture::of(q).inverse_dynamics(arm, dq, ddq)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_and_accelerations_are_derivatives() {
        let h = 1e-5;
        for time_s in [0.1, 0.9, 1.7, 2.5, 7.3] {
            let [before, now, after] = [time_s - h, time_s, time_s + h].map(reference);
            let dq = (after.q - before.q) / (2.0 * h);
            let ddq = (after.dq - before.dq) / (2.0 * h);
            assert!((dq - now.dq).amax() < 1e-8 && (ddq - now.ddq).amax() < 1e-8);
        }
        assert!(reference(0.0).dq.amax() + reference(0.0).q.amax() < 1e-15);
    }

    #[test]
    fn the_law_makes_the_error_linear() {
        let arm = Parameters::paper();
        let state = State {
            q: Vector2::new(0.3, -0.6),
            dq: Vector2::new(1.2, -0.8),
        };
        let reference = reference(1.3);
        let torque = computed_torque(&arm, 9.0, &state, &reference);
        let expected =
            reference.ddq + (reference.dq - state.dq) * 18.0 + (reference.q - state.q) * 81.0;
        assert!((arm.acceleration(&state, torque) - expected).amax() < 1e-10);
    }
}
