//! Mass, Coriolis, gravity, acceleration and energy: equations (1) to (4).
//!
//! Each of these is one term of a [`Posture`], for a caller that needs only that.

use super::{Parameters, Posture, State};
use crate::real::Real;
use nalgebra::{Matrix2, Vector2};

impl<T: Real> Parameters<T> {
    /// Mass matrix M(q) in kg m^2, see [`Posture::mass_diagonal`].
    pub fn mass(&self, q: Vector2<T>) -> Matrix2<T> {
        Matrix2::from_diagonal(&Posture::of(q).mass_diagonal(self))
    }

    /// Coriolis matrix Co(q, dq) in N m s/rad, in the choice of Christoffel:
    ///
    /// ```text
    /// Co = [ -h dq2/2  -h dq1/2 ]     h = -dM(1,1)/dq2
    ///      [  h dq1/2      0    ]
    /// ```
    ///
    /// `dM/dt - 2 Co` is skew symmetric. Equation (4) puts all of it in the
    /// first column; both choices give the same torque `Co dq`, up to the sign
    /// that (4) has reversed and its `L2/4`, which must read `M2 L2^2/4`.
    pub fn coriolis(&self, q: Vector2<T>, dq: Vector2<T>) -> Matrix2<T> {
        let half_h = Posture::of(q).mass_slope(self) * T::lit(0.5);
        Matrix2::new(-half_h * dq.y, -half_h * dq.x, half_h * dq.x, T::zero())
    }

    /// Viscous friction `F dq` in N m.
    pub fn viscous_torque(&self, dq: Vector2<T>) -> Vector2<T> {
        Vector2::new(self.b1 * dq.x, self.b2 * dq.y)
    }

    /// Gravity torque G(q) in N m, see [`Posture::gravity`].
    ///
    /// Also the torque that holds the arm at rest at q.
    pub fn gravity(&self, q: Vector2<T>) -> Vector2<T> {
        Posture::of(q).gravity(self)
    }

    /// Joint accelerations in rad/s^2 under a joint torque in N m: equation (1)
    /// solved for ddq.
    pub fn acceleration(&self, state: &State<T>, torque: Vector2<T>) -> Vector2<T> {
        Posture::of(state.q).forward_dynamics(self, state.dq, torque)
    }

    /// Kinetic and potential energy in J; the latter is 0 with both links level.
    pub fn energy(&self, state: &State<T>) -> T {
        let State { q, dq } = *state;
        let posture = Posture::of(q);
        let mass = posture.mass_diagonal(self);
        let kinetic = mass.dot(&dq.component_mul(&dq)) * T::lit(0.5);
        kinetic + posture.potential_energy(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Mounting;
    use nalgebra::Vector4;

    /// A step of Runge-Kutta, without torque.
    fn step(arm: &Parameters<f64>, x: Vector4<f64>, step_s: f64) -> Vector4<f64> {
        let slope = |x: Vector4<f64>| {
            let state = State::from_vector(x);
            let ddq = arm.acceleration(&state, Vector2::zeros());
            Vector4::new(x.z, x.w, ddq.x, ddq.y)
        };
        let k1 = slope(x);
        let k2 = slope(x + k1 * (step_s / 2.0));
        let k3 = slope(x + k2 * (step_s / 2.0));
        let k4 = slope(x + k3 * step_s);
        x + (k1 + (k2 + k3) * 2.0 + k4) * (step_s / 6.0)
    }

    #[test]
    fn an_arm_that_hangs_swings_about_zero_and_keeps_its_energy() {
        let arm = Parameters {
            b1: 0.0,
            b2: 0.0,
            mounting: Mounting::Hanging,
            ..Parameters::paper()
        };
        let start = State::at_rest(Vector2::new(0.6, -0.8));
        let energy = arm.energy(&start);
        let mut x = start.to_vector();
        let (mut drift, mut widest): (f64, f64) = (0.0, 0.0);
        let mut crossings = 0;
        for _ in 0..10_000 {
            let next = step(&arm, x, 1e-3);
            crossings += usize::from(next.x * x.x < 0.0);
            x = next;
            drift = drift.max((arm.energy(&State::from_vector(x)) - energy).abs());
            widest = widest.max(x.x.abs());
        }
        assert!(drift < 1e-9, "{drift:e} J");
        assert!(crossings > 10 && widest < 1.0, "{crossings}, {widest} rad");
    }
}
