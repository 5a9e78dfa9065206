//! The arm of the paper, exact, under torques that change once a period.

use armbridge_control::arm::{Mounting, Parameters, State};
use nalgebra::Vector2;

/// Runge-Kutta in steps of 0.25 ms.
const STEP_US: u32 = 250;

/// An arm, and where it is.
#[derive(Clone, Debug)]
pub(super) struct Plant {
    arm: Parameters<f64>,
    pub(super) state: State<f64>,
}

impl Plant {
    /// One joint somewhere, with a speed; the other upright.
    pub(super) fn new(joint: usize, angle_rad: f64, speed_rad_s: f64) -> Self {
        let mut state = State::at_rest(Vector2::zeros());
        state.q[joint] = angle_rad;
        state.dq[joint] = speed_rad_s;
        Self {
            arm: Parameters::paper(),
            state,
        }
    }

    /// The same, mounted like this.
    pub(super) fn mounted(self, mounting: Mounting) -> Self {
        let arm = Parameters {
            mounting,
            ..self.arm
        };
        Self { arm, ..self }
    }

    /// The board's model of it.
    pub(super) fn believed(&self) -> Parameters<f32> {
        self.arm.map(|number| number as f32)
    }

    /// As the monitors are given it.
    pub(super) fn seen(&self) -> State<f32> {
        State {
            q: self.state.q.cast(),
            dq: self.state.dq.cast(),
        }
    }

    /// A period under this torque in N m.
    pub(super) fn step(&mut self, torque_nm: Vector2<f64>, period_us: u32) {
        let dt = f64::from(STEP_US) * 1e-6;
        let slope = |state: &State<f64>| (state.dq, self.arm.acceleration(state, torque_nm));
        for _ in 0..period_us / STEP_US {
            let start = self.state;
            let after = |(dq, ddq): (Vector2<f64>, Vector2<f64>), dt: f64| State {
                q: start.q + dq * dt,
                dq: start.dq + ddq * dt,
            };
            let k1 = slope(&start);
            let k2 = slope(&after(k1, dt / 2.0));
            let k3 = slope(&after(k2, dt / 2.0));
            let k4 = slope(&after(k3, dt));
            self.state = State {
                q: start.q + (k1.0 + (k2.0 + k3.0) * 2.0 + k4.0) * (dt / 6.0),
                dq: start.dq + (k1.1 + (k2.1 + k3.1) * 2.0 + k4.1) * (dt / 6.0),
            };
        }
    }

    /// A torque that keeps one joint about upright.
    pub(super) fn hold(&self, joint: usize) -> f64 {
        let (q, dq) = (self.state.q[joint], self.state.dq[joint]);
        self.arm.gravity(self.state.q)[joint] - 5.0 * q - 0.5 * dq
    }
}
