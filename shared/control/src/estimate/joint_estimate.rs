//! The estimate of each joint: state of all estimators from one sample to the next.

use crate::arm::State;
use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// State of an estimator: joint by joint angle, speed, disturbance and their
/// covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct Estimate<T> {
    pub(super) joints: [JointEstimate<T>; JOINTS],
}

/// Angle in rad, speed in rad/s, disturbance in N m.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct JointEstimate<T> {
    pub(super) q: T,
    pub(super) dq: T,
    /// 0 from an estimator without disturbances.
    pub(super) d: T,
    /// Of the Kalman filter.
    pub(super) covariance: Covariance<T>,
    /// Of the backward difference.
    pub(super) difference: Difference<T>,
}

/// Covariance, upper triangle of (angle, speed, disturbance).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Covariance<T> {
    pub(super) qq: T,
    pub(super) qv: T,
    pub(super) qd: T,
    pub(super) vv: T,
    pub(super) vd: T,
    pub(super) dd: T,
}

checked!(Covariance<T> { qq, qv, qd, vv, vd, dd });

/// State of the backward difference.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Difference<T> {
    /// The last sample that the joint had, in rad.
    pub(super) angle: T,
    /// Periods since then.
    pub(super) age: T,
    /// The filtered speed in rad/s.
    pub(super) speed: T,
}

impl<T: Real> Estimate<T> {
    /// The state at the next samples after
    /// [`Estimator::advance`](super::Estimator::advance), at the present ones after
    /// [`Estimator::correct`](super::Estimator::correct).
    pub fn state(&self) -> State<T> {
        let [a, b] = &self.joints;
        State {
            q: Vector2::new(a.q, b.q),
            dq: Vector2::new(a.dq, b.dq),
        }
    }

    /// Torque in N m that acts on the joints without being commanded; zero from
    /// an estimator that does not look for it.
    pub fn disturbance(&self) -> Vector2<T> {
        let [a, b] = &self.joints;
        Vector2::new(a.d, b.d)
    }

    pub(super) fn set(&mut self, state: &State<T>) {
        for (joint, estimate) in self.joints.iter_mut().enumerate() {
            (estimate.q, estimate.dq) = (state.q[joint], state.dq[joint]);
        }
    }
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
