//! One joint's share of an [`Estimate`](super::Estimate): what any of the
//! estimators keeps from one sample to the next.

use crate::check_word::checked;
use crate::real::Real;

/// Angle in rad, speed in rad/s, disturbance in N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct JointEstimate<T> {
    pub(super) q: T,
    pub(super) dq: T,
    /// 0 from an estimator that does not look for one.
    pub(super) d: T,
    /// Of the Kalman filter.
    pub(super) covariance: Covariance<T>,
    /// Of the backward difference.
    pub(super) difference: Difference<T>,
}

/// Covariance, upper triangle of (angle, speed, disturbance).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Covariance<T> {
    pub(super) qq: T,
    pub(super) qv: T,
    pub(super) qd: T,
    pub(super) vv: T,
    pub(super) vd: T,
    pub(super) dd: T,
}

checked!(Covariance<T> { qq, qv, qd, vv, vd, dd });

/// What a difference is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference<T> {
    /// The last sample that the joint had, in rad.
    pub(super) angle: T,
    /// Periods since then.
    pub(super) age: T,
    /// The filtered speed in rad/s.
    pub(super) speed: T,
}

impl<T: Real> JointEstimate<T> {
    pub(super) fn new(q: T, dq: T, d: T, covariance: Covariance<T>) -> Self {
        Self {
            q,
            dq,
            d,
            covariance,
            difference: Difference {
                angle: q,
                age: T::zero(),
                speed: dq,
            },
        }
    }
}

impl<T: Real> Covariance<T> {
    pub(super) fn zero() -> Self {
        let o = T::zero();
        Self {
            qq: o,
            qv: o,
            qd: o,
            vv: o,
            vd: o,
            dd: o,
        }
    }
}
