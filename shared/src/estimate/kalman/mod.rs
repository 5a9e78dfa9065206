//! An extended Kalman filter that knows what pushes the arm.
//!
//! Six states: both angles, both speeds, and for each joint a *disturbance*, a
//! torque that nobody commanded: gravity off its model, friction, a motor weaker
//! than calibrated. It walks at random, so what the samples show of it is kept,
//! and a controller that takes it off its torque leaves no error at rest.
//!
//! ```text
//! q'  = dq
//! dq' = M(q)^-1 (torque + d - Co(q, dq) dq - F dq - fc s(dq / vs) - G(q))
//! d'  = noise
//! ```
//!
//! # Mean
//!
//! The whole nonlinear model, coupling included, taken over a period by the
//! exact discretisation about upright: `x + P (dq, dq')` with
//! `P = integral of exp(A t)`, one 2 x 2 block per joint. That is exact for the
//! linear part at any period, where Euler's step is off by 15 % at 45 ms.
//!
//! # Covariance
//!
//! M(q) is diagonal, so the joints act on each other through gravity and
//! Coriolis torque alone. Their covariances are kept apart: two 3 x 3 filters,
//! each corrected by one scalar, no inverse, six numbers a joint. What is left
//! out is of second order in the angles' spread.
//!
//! # Dry friction
//!
//! `s` is a smooth sign: odd, flat beyond ±1, slope 3/2 at 0. `vs` is at least
//! what one period's friction can do to a speed, so that the model does not
//! overshoot rest.
//!
//! # Noise
//!
//! A rounded count is off by 1/12 count^2 on top of what the converter adds, one
//! count rms; both are in the angle's variance.

mod axis;
#[cfg(test)]
mod tests;

use super::Estimate;
use super::joint_estimate::Covariance;
use crate::JOINTS;
use crate::arm::{Parameters, Posture, State};
use crate::check_word::checked;
use crate::real::Real;
use axis::Axis;
use nalgebra::Vector2;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// What the filter believes about the arm and its samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Tuning<T> {
    /// Noise of an angle sample in rad rms, rounding included.
    pub angle_rad: T,
    /// Acceleration that no torque explains, as white noise:
    /// rad/s^2 per square root of Hz.
    pub acceleration: T,
    /// How fast a disturbance may walk: N m per square root of s.
    pub disturbance: T,
    /// Coulomb friction in N m; 0 leaves friction to the disturbance.
    pub coulomb_nm: T,
    /// Speed in rad/s from which on it is fully there.
    pub slide_rad_s: T,
}

impl<T: Real> Tuning<T> {
    /// For an arm that stands: noise of one count and its rounding, the bench's
    /// friction, and walks chosen on the bench, quiet at rest and quick enough to
    /// undo a push within a few tenths of a second.
    pub fn standing() -> Self {
        Self {
            angle_rad: T::lit(0.0053),
            acceleration: T::lit(0.3),
            disturbance: T::lit(0.2),
            coulomb_nm: T::lit(0.04),
            slide_rad_s: T::lit(0.1),
        }
    }

    /// Inside these a filter of single precision stays well conditioned, and
    /// outside them no arm is; NaN is inside nothing.
    fn is_valid(&self) -> bool {
        let within = |x: T, low: f64, high: f64| x >= T::lit(low) && x <= T::lit(high);
        within(self.angle_rad, 1e-5, 1.0)
            && within(self.acceleration, 1e-4, 1e3)
            && within(self.disturbance, 0.0, 10.0)
            && within(self.coulomb_nm, 0.0, 1.0)
            && within(self.slide_rad_s, 1e-3, 10.0)
    }
}

/// The filter's design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kalman<T> {
    variance: T,
    axes: [Axis<T>; JOINTS],
    initial_covariance: Covariance<T>,
}

checked!(Kalman<T> { variance, axes, initial_covariance });

impl<T: Real> Kalman<T> {
    /// For an arm sampled every `period_s`.
    ///
    /// `None` for a tuning that is not finite, or beyond all reason. No noise at
    /// all is: the filter would trust its samples, or its model, for ever.
    pub fn new(arm: &Parameters<T>, period_s: T, tuning: &Tuning<T>) -> Option<Self> {
        if !tuning.is_valid() {
            return None;
        }
        let upright = Vector2::zeros();
        let steps = arm.linearise(upright).integral(period_s);
        let mass = arm.mass(upright).diagonal();
        Some(Self {
            variance: tuning.angle_rad * tuning.angle_rad,
            axes: [
                Axis::new(tuning, period_s, steps[0], mass.x, arm.b1),
                Axis::new(tuning, period_s, steps[1], mass.y, arm.b2),
            ],
            initial_covariance: axis::initial_covariance(tuning),
        })
    }

    pub(super) fn initial_covariance(&self) -> Covariance<T> {
        self.initial_covariance
    }

    /// See [`Estimator::correct`](super::Estimator::correct).
    pub fn correct(&self, estimate: &mut Estimate<T>, measured: [Option<T>; JOINTS]) -> State<T> {
        for (joint, angle) in estimate.joints.iter_mut().zip(measured) {
            if let Some(angle) = angle {
                axis::correct(joint, angle, self.variance);
            }
        }
        estimate.state()
    }

    /// See [`Estimator::advance`](super::Estimator::advance).
    pub fn advance(
        &self,
        arm: &Parameters<T>,
        posture: &Posture<T>,
        estimate: &mut Estimate<T>,
        torque: Vector2<T>,
    ) -> State<T> {
        let state = estimate.state();
        let mass = posture.mass_diagonal(arm);
        let slope = posture.gravity_slope(arm);
        // Gravity, and all that the joints do to each other.
        let coriolis = posture.coriolis_torque(arm, state.dq);
        let given = torque - coriolis - posture.gravity(arm);
        let stiffness = [slope.m11, slope.m22];
        let joints = estimate.joints.iter_mut().zip(&self.axes);
        for (i, (joint, axis)) in joints.enumerate() {
            axis.advance(joint, given[i], mass[i], stiffness[i]);
        }
        estimate.state()
    }
}
