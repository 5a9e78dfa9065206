//! A smooth arm in free motion: Runge-Kutta of fourth order, for what the
//! plant's integration cannot do (other equations) or does too finely (fits).

use armbridge_shared::arm::{Parameters, State};
use nalgebra::Vector2;

/// One step of `ddq = acceleration(state)`.
pub(crate) fn step(
    state: &State<f64>,
    step_s: f64,
    acceleration: impl Fn(&State<f64>) -> Vector2<f64>,
) -> State<f64> {
    let slope = |x: State<f64>| {
        let ddq = acceleration(&x);
        State { q: x.dq, dq: ddq }.to_vector()
    };
    let x = state.to_vector();
    let at = |x| slope(State::from_vector(x));
    let k1 = at(x);
    let k2 = at(x + k1 * (step_s / 2.0));
    let k3 = at(x + k2 * (step_s / 2.0));
    let k4 = at(x + k3 * step_s);
    State::from_vector(x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (step_s / 6.0))
}

/// Angles of joint 1 at rest at `from_rad` under a constant torque, every
/// `period_s`, so many of them; joint 2 stays at 0. Without dry friction.
pub(crate) fn first_joint(
    arm: &Parameters<f64>,
    from_rad: f64,
    torque_nm: f64,
    period_s: f64,
    samples: usize,
) -> Vec<f64> {
    /// Steps per period: at 45 ms a step is 5 ms, and its error below 1e-7 rad.
    const STEPS: u32 = 9;

    let torque = Vector2::new(torque_nm, 0.0);
    let mut state = State::at_rest(Vector2::new(from_rad, 0.0));
    let mut angles = Vec::with_capacity(samples);
    for _ in 0..samples {
        angles.push(state.q.x);
        for _ in 0..STEPS {
            state = step(&state, period_s / f64::from(STEPS), |x| {
                arm.acceleration(x, torque)
            });
        }
    }
    angles
}
