//! Speed as the difference of two angles.
//!
//! At 1 kHz one encoder count between two samples is 5.1 rad/s, so the plain
//! difference is noise; a low pass of 20 ms makes it usable. At the paper's
//! 45 ms a count is 0.11 rad/s and the plain difference is good enough.

use super::joint_estimate::Estimate;
use super::model::Model;
use crate::arm::{Parameters, Posture, State};
use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Backward difference through a first-order low pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteDifference<T> {
    model: Model<T>,
    period_s: T,
    /// Share of a new difference in the filtered one.
    share: T,
}

checked!(FiniteDifference<T> { model, period_s, share });

impl<T: Real> FiniteDifference<T> {
    /// With a low pass of time constant `filter_s`, or none if that is 0.
    pub fn new(model: Model<T>, period_s: T, filter_s: T) -> Self {
        let share = if filter_s > T::zero() {
            T::one() - (-period_s / filter_s).exp()
        } else {
            T::one()
        };
        Self {
            model,
            period_s,
            share,
        }
    }

    /// See [`Estimator::correct`](super::Estimator::correct). The model's
    /// prediction stands for a joint without a sample.
    pub fn correct(&self, estimate: &mut Estimate<T>, measured: [Option<T>; JOINTS]) -> State<T> {
        for (joint, measured) in estimate.joints.iter_mut().zip(measured) {
            let last = &mut joint.difference;
            last.age += T::one();
            if let Some(angle) = measured {
                let difference = (angle - last.angle) / (last.age * self.period_s);
                joint.q = angle;
                joint.dq = last.speed + self.share * (difference - last.speed);
                (last.angle, last.age) = (angle, T::zero());
            }
            last.speed = joint.dq;
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
        let state = self.model.step(arm, posture, &estimate.state(), torque);
        estimate.set(&state);
        state
    }
}
