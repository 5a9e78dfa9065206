//! Mass, Coriolis, gravity, acceleration and energy: equations (1) to (4).

use super::{Parameters, State};
use crate::real::Real;
use nalgebra::{Matrix2, Vector2};

impl<T: Real> Parameters<T> {
    /// Mass matrix M(q) in kg m^2, equation (3) with `M1 L1^2/4`.
    ///
    /// Diagonal for every q: the two axes stay perpendicular.
    pub fn mass(&self, q: Vector2<T>) -> Matrix2<T> {
        Matrix2::from_diagonal(&self.mass_diagonal(q.y.sine_cosine().1))
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
        let (sin2, cos2) = q.y.sine_cosine();
        let half_h = self.mass_slope(sin2, cos2) * T::lit(0.5);
        Matrix2::new(-half_h * dq.y, -half_h * dq.x, half_h * dq.x, T::zero())
    }

    /// Gravity torque G(q) in N m, equation (2) with both rows over 2.
    ///
    /// Also the torque that holds the arm at rest at q.
    pub fn gravity(&self, q: Vector2<T>) -> Vector2<T> {
        let (sin1, cos1) = q.x.sine_cosine();
        let (sin2, cos2) = q.y.sine_cosine();
        self.gravity_at(sin1, cos1, sin2, cos2)
    }

    /// Joint accelerations in rad/s^2 under a joint torque in N m: equation (1)
    /// solved for ddq.
    pub fn acceleration(&self, state: &State<T>, torque: Vector2<T>) -> Vector2<T> {
        let State { q, dq } = *state;
        let (sin1, cos1) = q.x.sine_cosine();
        let (sin2, cos2) = q.y.sine_cosine();
        let h = self.mass_slope(sin2, cos2);
        let coriolis = Vector2::new(-h * dq.x * dq.y, h * T::lit(0.5) * dq.x * dq.x);
        let viscous = Vector2::new(self.b1 * dq.x, self.b2 * dq.y);
        let net = torque - coriolis - viscous - self.gravity_at(sin1, cos1, sin2, cos2);
        net.component_div(&self.mass_diagonal(cos2))
    }

    /// Kinetic and potential energy in J; the latter is 0 with both links level.
    pub fn energy(&self, state: &State<T>) -> T {
        let State { q, dq } = *state;
        let cos2 = q.y.sine_cosine().1;
        let kinetic = self.mass_diagonal(cos2).dot(&dq.component_mul(&dq)) * T::lit(0.5);
        let height_moment = self.moment_1() + self.moment_2() * cos2;
        kinetic + self.g * q.x.sine_cosine().1 * height_moment
    }

    fn mass_diagonal(&self, cos2: T) -> Vector2<T> {
        let quarter = T::lit(0.25);
        let arm = self.l1 + self.l2 * cos2 * T::lit(0.5);
        Vector2::new(
            self.i1x
                + self.m1 * self.l1 * self.l1 * quarter
                + self.i2z
                + cos2 * cos2 * (self.i2x - self.i2z)
                + self.m2 * arm * arm,
            self.m2 * self.l2 * self.l2 * quarter + self.i2y,
        )
    }

    /// h = -dM(1,1)/dq2, the bracket of B(1,1) in (4).
    fn mass_slope(&self, sin2: T, cos2: T) -> T {
        let link = self.m2 * self.l2 * self.l2 * T::lit(0.25) + self.i2x - self.i2z;
        T::lit(2.0) * sin2 * cos2 * link + self.l1 * self.l2 * self.m2 * sin2
    }

    fn gravity_at(&self, sin1: T, cos1: T, sin2: T, cos2: T) -> Vector2<T> {
        Vector2::new(
            -self.g * sin1 * (self.moment_1() + self.moment_2() * cos2),
            -self.g * self.moment_2() * cos1 * sin2,
        )
    }
}
