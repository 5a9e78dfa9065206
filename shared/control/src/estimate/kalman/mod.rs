//! An extended Kalman filter with disturbance torques.
//!
//! Six states: both angles, both speeds, and for each joint a *disturbance*, a
//! torque that was not commanded: gravity off its model, friction, a motor weaker
//! than calibrated. It walks at random, so what the samples show of it is kept,
//! and a controller that takes it off its torque leaves no error at rest.
//!
//! ```text
//! q'  = dq
//! dq' = M(q)^-1 (torque + d - Co(q, dq) dq - F dq - f s(dq / vs) - G(q))
//! d'  = noise
//! f   = fc + load |torque - F dq + G(q)|
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
//! `load` is that of the gears ([`gear_torque`]); a filter without Coulomb friction has none.
//!
//! # Noise
//!
//! A rounded count is off by 1/12 count^2 on top of what the converter adds, one
//! count rms; both are in the angle's variance.

mod axis;
#[cfg(test)]
mod tests;
mod tuning;

pub use tuning::Tuning;

use super::joint_estimate::{Covariance, Estimate};
use crate::arm::{Parameters, Posture, State};
use crate::check_word::checked;
use crate::controller::friction::gear_torque;
use crate::real::Real;
use armbridge_servo::JOINTS;
use axis::{Axis, JointConstants};
use nalgebra::Vector2;

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
        Self::with_load(arm, period_s, tuning, [T::zero(); JOINTS])
    }

    /// The same with load friction: dry friction in N m per N m that each joint's gears transmit.
    pub fn with_load(
        arm: &Parameters<T>,
        period_s: T,
        tuning: &Tuning<T>,
        load: [T; JOINTS],
    ) -> Option<Self> {
        if !tuning.is_valid() {
            return None;
        }
        let upright = Vector2::zeros();
        let steps = arm.linearise(upright).integral(period_s);
        let mass = arm.mass(upright).diagonal();
        let (weight_nm, viscous) = (arm.weight_nm(), [arm.b1, arm.b2]);
        let axis = |joint: usize| {
            let constants = JointConstants {
                mass: mass[joint],
                viscous: viscous[joint],
                weight_nm: weight_nm[joint],
                load: load[joint],
            };
            Axis::new(tuning, period_s, steps[joint], &constants)
        };
        Some(Self {
            variance: tuning.angle_rad * tuning.angle_rad,
            axes: [axis(0), axis(1)],
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
        let gears = gear_torque(arm, posture, &state, torque);
        let stiffness = [slope.m11, slope.m22];
        let joints = estimate.joints.iter_mut().zip(&self.axes);
        for (i, (joint, axis)) in joints.enumerate() {
            axis.advance(joint, given[i], gears[i], mass[i], stiffness[i]);
        }
        estimate.state()
    }
}
