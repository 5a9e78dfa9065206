//! One joint of the filter: three states, one measured.
//!
//! F, the step's Jacobian, is `I + P J` with the P of the step and the J of the
//! continuous model, written out; its last row is (0 0 1). The covariance is
//! symmetric and kept as its upper triangle.

use super::tuning::Tuning;
use crate::check_word::checked;
use crate::estimate::joint_estimate::{Covariance, JointEstimate};
use crate::real::Real;
use nalgebra::Matrix2;

/// Largest estimated disturbance, in N m: a push of 0.2, a fifth of the
/// torque missing, and friction, with room. An arm that is held by hand would
/// otherwise wind it up, and fly when it is released.
const DISTURBANCE_MAX_NM: f64 = 0.5;

/// Constants of one joint's filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis<T> {
    /// Integral of exp(A t) over a period, rows angle and speed.
    step: Matrix2<T>,
    viscous: T,
    coulomb: T,
    /// Friction per torque on the gears.
    load: T,
    per_slide_speed: T,
    /// Process noise per period.
    noise: Covariance<T>,
}

checked!(Axis<T> { step, viscous, coulomb, load, per_slide_speed, noise });

/// Constants of one joint of the arm.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointConstants<T> {
    /// Inertia upright, in kg m^2.
    pub(super) mass: T,
    /// Viscous friction in N m s/rad.
    pub(super) viscous: T,
    /// Largest gravity torque in N m.
    pub(super) weight_nm: T,
    /// Dry friction in N m per N m that the gears transmit.
    pub(super) load: T,
}

/// Before the first sample: an angle as good as one, any slow speed.
pub(super) fn initial_covariance<T: Real>(tuning: &Tuning<T>) -> Covariance<T> {
    let square = |x: T| x * x;
    Covariance {
        qq: square(tuning.angle_rad),
        vv: square(T::lit(0.1)),
        dd: square(T::lit(0.05)),
        ..Covariance::zero()
    }
}

impl<T: Real> Axis<T> {
    /// With the exact step about upright.
    pub(super) fn new(
        tuning: &Tuning<T>,
        period_s: T,
        step: Matrix2<T>,
        joint: &JointConstants<T>,
    ) -> Self {
        let JointConstants {
            mass,
            viscous,
            weight_nm,
            load,
        } = *joint;
        // Friction of a joint without a model of it is left to the disturbance, load or not.
        let load = if tuning.coulomb_nm > T::zero() {
            load
        } else {
            T::zero()
        };
        // With gears that hold the arm level: its weight, and the motor's torque against it.
        let most = tuning.coulomb_nm + load * T::lit(2.0) * weight_nm;
        // What a period of full friction does to the speed, and half of that
        // again for the slope of the smooth sign; twice, for good measure.
        let reach = most * step.m22 / mass * T::lit(3.0);
        // White acceleration over a period, on angle and speed.
        let push = tuning.acceleration * tuning.acceleration;
        let third = T::lit(1.0 / 3.0);
        Self {
            step,
            viscous,
            coulomb: tuning.coulomb_nm,
            load,
            per_slide_speed: T::one() / tuning.slide_rad_s.max(reach),
            noise: Covariance {
                qq: push * period_s * period_s * period_s * third,
                qv: push * period_s * period_s * T::lit(0.5),
                qd: T::zero(),
                vv: push * period_s,
                vd: T::zero(),
                dd: tuning.disturbance * tuning.disturbance * period_s,
            },
        }
    }

    /// To the next sample: under the torque `given` after gravity and coupling,
    /// with gravity's `stiffness`; `gears` is the torque that the gears transmit.
    pub(super) fn advance(
        &self,
        joint: &mut JointEstimate<T>,
        given: T,
        gears: T,
        mass: T,
        stiffness: T,
    ) {
        let (friction, friction_slope) = self.friction(joint.dq, gears);
        let per_mass = T::one() / mass;
        let net = given + joint.d - self.viscous * joint.dq - friction;
        let acceleration = net * per_mass;
        let speed = joint.dq;
        let p = &self.step;
        joint.q += p.m11 * speed + p.m12 * acceleration;
        joint.dq += p.m21 * speed + p.m22 * acceleration;

        // F = I + P J, J = [0 1 0; -stiffness/m -damping/m 1/m].
        let a_q = -stiffness * per_mass;
        let a_v = -(self.viscous + friction_slope) * per_mass;
        let one = T::one();
        let f11 = one + p.m12 * a_q;
        let f12 = p.m11 + p.m12 * a_v;
        let f13 = p.m12 * per_mass;
        let f21 = p.m22 * a_q;
        let f22 = one + p.m21 + p.m22 * a_v;
        let f23 = p.m22 * per_mass;
        let Covariance {
            qq,
            qv,
            qd,
            vv,
            vd,
            dd,
        } = joint.covariance;
        // Rows of F P.
        let r1q = f11 * qq + f12 * qv + f13 * qd;
        let r1v = f11 * qv + f12 * vv + f13 * vd;
        let r1d = f11 * qd + f12 * vd + f13 * dd;
        let r2q = f21 * qq + f22 * qv + f23 * qd;
        let r2v = f21 * qv + f22 * vv + f23 * vd;
        let r2d = f21 * qd + f22 * vd + f23 * dd;
        let noise = &self.noise;
        joint.covariance = Covariance {
            qq: r1q * f11 + r1v * f12 + r1d * f13 + noise.qq,
            qv: r2q * f11 + r2v * f12 + r2d * f13 + noise.qv,
            qd: r1d,
            vv: r2q * f21 + r2v * f22 + r2d * f23 + noise.vv,
            vd: r2d,
            dd: dd + noise.dd,
        };
    }

    /// Dry friction at a speed, and its slope; that of its load by the speed is left out.
    fn friction(&self, speed: T, gears: T) -> (T, T) {
        let most = self.coulomb + self.load * gears.abs();
        let s = speed * self.per_slide_speed;
        if s.abs() >= T::one() {
            return (most.copysign(s), T::zero());
        }
        let (half, three_half) = (T::lit(0.5), T::lit(1.5));
        let square = s * s;
        (
            most * s * (three_half - half * square),
            most * self.per_slide_speed * three_half * (T::one() - square),
        )
    }
}

/// Takes a sample of a joint, in rad, with noise of this variance.
pub(super) fn correct<T: Real>(joint: &mut JointEstimate<T>, angle: T, variance: T) {
    let p = &mut joint.covariance;
    let per_spread = T::one() / (p.qq + variance);
    let (k_q, k_v, k_d) = (p.qq * per_spread, p.qv * per_spread, p.qd * per_spread);
    let innovation = angle - joint.q;
    joint.q += k_q * innovation;
    joint.dq += k_v * innovation;
    let limit = T::lit(DISTURBANCE_MAX_NM);
    joint.d = (joint.d + k_d * innovation).clamp(-limit, limit);
    let (qv, qd) = (p.qv, p.qd);
    // `variance k_q` is `qq - k_q qq` without the difference.
    p.qq = variance * k_q;
    p.qv = variance * k_v;
    p.qd = variance * k_d;
    p.vv -= k_v * qv;
    p.vd -= k_v * qd;
    p.dd -= k_d * qd;
}
