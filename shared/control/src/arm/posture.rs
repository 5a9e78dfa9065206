//! The arm at given joint angles: equations (1) to (4) term by term.
//!
//! Every term uses the same two sines and two cosines, and these are its most
//! expensive part. A [`Posture`] holds them, so that a tick that needs
//! several terms computes them once.

use super::Parameters;
use crate::real::Real;
use nalgebra::{Matrix2, Vector2};

/// Sines and cosines of both joint angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture<T> {
    sin1: T,
    cos1: T,
    sin2: T,
    cos2: T,
}

impl<T: Real> Posture<T> {
    /// The posture at joint angles in rad.
    pub fn of(q: Vector2<T>) -> Self {
        let (sin1, cos1) = q.x.sine_cosine();
        let (sin2, cos2) = q.y.sine_cosine();
        Self {
            sin1,
            cos1,
            sin2,
            cos2,
        }
    }

    /// Diagonal of the mass matrix M(q) in kg m^2, equation (3) with
    /// `M1 L1^2/4`. There is nothing beside the diagonal: the two axes stay
    /// perpendicular.
    pub fn mass_diagonal(&self, arm: &Parameters<T>) -> Vector2<T> {
        let (quarter, cos2) = (T::lit(0.25), self.cos2);
        let reach = arm.l1 + arm.l2 * cos2 * T::lit(0.5);
        Vector2::new(
            arm.i1x
                + arm.m1 * arm.l1 * arm.l1 * quarter
                + arm.i2z
                + cos2 * cos2 * (arm.i2x - arm.i2z)
                + arm.m2 * reach * reach,
            arm.m2 * arm.l2 * arm.l2 * quarter + arm.i2y,
        )
    }

    /// h = -dM(1,1)/dq2 in kg m^2/rad, the bracket of B(1,1) in (4).
    pub fn mass_slope(&self, arm: &Parameters<T>) -> T {
        let (sin2, cos2) = (self.sin2, self.cos2);
        let link = arm.m2 * arm.l2 * arm.l2 * T::lit(0.25) + arm.i2x - arm.i2z;
        T::lit(2.0) * sin2 * cos2 * link + arm.l1 * arm.l2 * arm.m2 * sin2
    }

    /// Torque `Co(q, dq) dq` in N m; the same for every choice of Co.
    pub fn coriolis_torque(&self, arm: &Parameters<T>, dq: Vector2<T>) -> Vector2<T> {
        let h = self.mass_slope(arm);
        Vector2::new(-h * dq.x * dq.y, h * T::lit(0.5) * dq.x * dq.x)
    }

    /// Gravity torque G(q) in N m, equation (2) with both rows over 2: what
    /// holds the arm at rest here. An arm that hangs has it the other way round.
    pub fn gravity(&self, arm: &Parameters<T>) -> Vector2<T> {
        let (sin1, cos1, sin2, cos2) = (self.sin1, self.cos1, self.sin2, self.cos2);
        let g = arm.pull_to_foot();
        Vector2::new(
            -g * sin1 * (arm.moment_1() + arm.moment_2() * cos2),
            -g * arm.moment_2() * cos1 * sin2,
        )
    }

    /// dG/dq in N m/rad: the stiffness of gravity, negative near q = 0,
    /// and positive there if the arm hangs.
    pub fn gravity_slope(&self, arm: &Parameters<T>) -> Matrix2<T> {
        let (sin1, cos1, sin2, cos2) = (self.sin1, self.cos1, self.sin2, self.cos2);
        let g = arm.pull_to_foot();
        let coupling = g * arm.moment_2() * sin1 * sin2;
        Matrix2::new(
            -g * cos1 * (arm.moment_1() + arm.moment_2() * cos2),
            coupling,
            coupling,
            -g * arm.moment_2() * cos1 * cos2,
        )
    }

    /// Potential energy in J, 0 with both links level.
    pub fn potential_energy(&self, arm: &Parameters<T>) -> T {
        let height_moment = arm.moment_1() + arm.moment_2() * self.cos2;
        arm.pull_to_foot() * self.cos1 * height_moment
    }

    /// Joint accelerations in rad/s^2 at speeds `dq` under a joint torque in
    /// N m: equation (1) solved for ddq.
    pub fn forward_dynamics(
        &self,
        arm: &Parameters<T>,
        dq: Vector2<T>,
        torque: Vector2<T>,
    ) -> Vector2<T> {
        let net =
            torque - self.coriolis_torque(arm, dq) - arm.viscous_torque(dq) - self.gravity(arm);
        net.component_div(&self.mass_diagonal(arm))
    }

    /// The joint torque in N m that accelerates by `ddq` at speeds `dq`:
    /// equation (1) as it stands.
    #[inline]
    pub fn inverse_dynamics(
        &self,
        arm: &Parameters<T>,
        dq: Vector2<T>,
        ddq: Vector2<T>,
    ) -> Vector2<T> {
        self.mass_diagonal(arm).component_mul(&ddq)
            + self.coriolis_torque(arm, dq)
            + arm.viscous_torque(dq)
            + self.gravity(arm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Mounting;

    fn arms() -> [Parameters<f64>; 2] {
        let arm = Parameters::paper();
        [Mounting::Upright, Mounting::Hanging].map(|mounting| Parameters { mounting, ..arm })
    }

    #[test]
    fn forward_and_inverse_dynamics_undo_each_other() {
        for i in 0..1000 {
            let angle = f64::from(i);
            let posture = Posture::of(Vector2::new(angle.sin() * 3.0, (angle * 1.7).cos() * 3.0));
            let dq = Vector2::new((angle * 0.3).cos(), (angle * 0.9).sin()) * 5.0;
            let ddq = Vector2::new((angle * 2.3).sin(), (angle * 0.6).cos()) * 40.0;
            for arm in arms() {
                let torque = posture.inverse_dynamics(&arm, dq, ddq);
                let error = posture.forward_dynamics(&arm, dq, torque) - ddq;
                assert!(error.amax() < 1e-12, "{error}");
            }
        }
    }

    /// An arm that hangs at q is one that stands at a half turn of joint 1 more: there
    /// its links are in the same place, and so is its energy. Gravity takes the same
    /// torque, for both joints turn the same way about the same axes of it.
    #[test]
    fn an_arm_that_hangs_is_one_that_stands_upside_down() {
        let [standing, hanging] = arms();
        for i in 0..100 {
            let q = Vector2::new(f64::from(i).sin() * 3.0, f64::from(i).cos() * 3.0);
            let over = Posture::of(q + Vector2::new(core::f64::consts::PI, 0.0));
            let here = Posture::of(q);
            let gravity = here.gravity(&hanging) - over.gravity(&standing);
            let slope = here.gravity_slope(&hanging) - over.gravity_slope(&standing);
            let energy = here.potential_energy(&hanging) - over.potential_energy(&standing);
            let most = gravity.amax().max(slope.amax()).max(energy.abs());
            assert!(most < 1e-14, "{q}: {most:e}");
        }
    }

    #[test]
    fn gravity_pulls_one_that_stands_over_and_one_that_hangs_back() {
        let [standing, hanging] = arms().map(|arm| {
            arm.linearise(Vector2::zeros())
                .a
                .fixed_view::<2, 2>(2, 0)
                .into_owned()
        });
        assert!(standing.m11 > 10.0 && standing.m22 > 5.0, "{standing}");
        assert!((standing + hanging).amax() < 1e-12, "{hanging}");
    }
}
