//! The arm near a setpoint, in continuous time.

use super::{Discrete, Parameters, Posture};
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Matrix4, Matrix4x2, Vector2};

/// `d/dt (x - x_ref) = A (x - x_ref) + B (torque - G(q_ref))` with
/// x = [q1, q2, dq1, dq2].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<T> {
    /// State matrix in 1/s.
    pub a: Matrix4<T>,
    /// Input matrix.
    pub b: Matrix4x2<T>,
}

impl<T: Real> Parameters<T> {
    /// Linearises equation (1) about rest at `q_ref`, held there by the torque
    /// `G(q_ref)`. Analytic: M and F are diagonal, and Co vanishes at rest.
    pub fn linearise(&self, q_ref: Vector2<T>) -> Linear<T> {
        let posture = Posture::of(q_ref);
        let mass = posture.mass_diagonal(self);
        let stiffness = posture.gravity_slope(self);
        let mut a = Matrix4::zeros();
        a.fixed_view_mut::<2, 2>(0, 2).fill_with_identity();
        a.fixed_view_mut::<2, 2>(2, 0).copy_from(&Matrix2::new(
            -stiffness.m11 / mass.x,
            -stiffness.m12 / mass.x,
            -stiffness.m21 / mass.y,
            -stiffness.m22 / mass.y,
        ));
        a.m33 = -self.b1 / mass.x;
        a.m44 = -self.b2 / mass.y;
        let mut b = Matrix4x2::zeros();
        b.m31 = T::one() / mass.x;
        b.m42 = T::one() / mass.y;
        Linear { a, b }
    }

    /// dG/dq in N m/rad, see [`Posture::gravity_slope`].
    pub fn gravity_slope(&self, q: Vector2<T>) -> Matrix2<T> {
        Posture::of(q).gravity_slope(self)
    }
}

impl<T: Real> Linear<T> {
    /// Forward Euler, the discretisation of the paper: `I + A T` and `B T`.
    ///
    /// At 45 ms its entries are off by up to 0.13 in A and 0.26 in B.
    pub fn euler(&self, period_s: T) -> Discrete<T> {
        Discrete {
            a: Matrix4::identity() + self.a * period_s,
            b: self.b * period_s,
        }
    }

    /// Exact discretisation for a torque that is constant over each period.
    ///
    /// With `Phi(T) = I + A T/2! + (A T)^2/3! + ...` it is `I + A T Phi` and
    /// `T Phi B`. Phi is summed for a period halved until its terms fall fast,
    /// then doubled back. What is doubled is Phi and `E = A T Phi`, never
    /// `I + E`: so a short period costs no digits, which matters in `f32`.
    pub fn zero_order_hold(&self, period_s: T) -> Discrete<T> {
        let (phi, growth) = self.mean_and_growth(period_s);
        Discrete {
            a: Matrix4::identity() + growth,
            b: phi * self.b * period_s,
        }
    }

    /// The integral of `exp(A t)` over a period for joints 1 and 2 alone, angle
    /// before speed: `x + P x'` is the exact state after it, about upright.
    pub fn integral(&self, period_s: T) -> [Matrix2<T>; JOINTS] {
        let p = self.mean_and_growth(period_s).0 * period_s;
        [
            Matrix2::new(p.m11, p.m13, p.m31, p.m33),
            Matrix2::new(p.m22, p.m24, p.m42, p.m44),
        ]
    }

    /// `Phi(T)` and `A T Phi(T)`.
    fn mean_and_growth(&self, period_s: T) -> (Matrix4<T>, Matrix4<T>) {
        /// The 15th term of the series is below 1e-16 of the first.
        const LARGEST_NORM: f64 = 0.5;
        const TERMS: u8 = 14;
        /// Enough for any finite `f32`; a matrix that is not finite stops here.
        const MOST_HALVINGS: u8 = 128;

        let half = T::lit(0.5);
        let mut scaled = self.a * period_s;
        let mut halvings = 0;
        while scaled.norm() > T::lit(LARGEST_NORM) && halvings < MOST_HALVINGS {
            scaled *= half;
            halvings += 1;
        }

        // Horner: I + X/2 (I + X/3 (I + X/4 (...))).
        let mut phi = Matrix4::identity();
        for term in (2..=TERMS).rev() {
            phi = Matrix4::identity() + scaled * phi / T::lit(f64::from(term));
        }
        let mut growth = scaled * phi;
        for _ in 0..halvings {
            phi += phi * growth * half;
            growth = growth * T::lit(2.0) + growth * growth;
        }
        (phi, growth)
    }
}
