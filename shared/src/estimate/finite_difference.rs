//! Speed as the difference of two angles.
//!
//! At 1 kHz one encoder count between two samples is 5.1 rad/s, so the plain
//! difference is noise; a low pass of 20 ms makes it usable. At the paper's
//! 45 ms a count is 0.11 rad/s and the plain difference is good enough.

use super::model::Model;
use crate::JOINTS;
use crate::arm::State;
use crate::real::Real;
use nalgebra::Vector2;

/// Backward difference through a first-order low pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteDifference<T> {
    model: Model<T>,
    period_s: T,
    /// Share of a new difference in the filtered one.
    share: T,
    last: [Sample<T>; JOINTS],
    /// The model's state at the next sample.
    prior: State<T>,
    estimate: State<T>,
}

/// The last sample that a joint had.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample<T> {
    angle: T,
    /// Periods since then.
    age: T,
}

impl<T: Real> FiniteDifference<T> {
    /// With a low pass of time constant `filter_s`, or none if that is 0; at
    /// rest upright.
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
            last: [Sample::new(T::zero()); JOINTS],
            prior: State::at_rest(Vector2::zeros()),
            estimate: State::at_rest(Vector2::zeros()),
        }
    }

    /// See [`Estimator::reset`](super::Estimator::reset).
    pub fn reset(&mut self, q: Vector2<T>) {
        self.last = [Sample::new(q.x), Sample::new(q.y)];
        self.prior = State::at_rest(q);
        self.estimate = self.prior;
    }

    pub(super) fn prior(&self) -> State<T> {
        self.prior
    }

    /// Goes on from this state at the next samples.
    pub(super) fn adopt(&mut self, state: State<T>) {
        self.last = [Sample::new(state.q.x), Sample::new(state.q.y)];
        self.prior = state;
        self.estimate = state;
    }

    /// See [`Estimator::correct`](super::Estimator::correct).
    pub fn correct(&mut self, measured: [Option<T>; JOINTS]) -> State<T> {
        let before = self.estimate;
        // What the model expects stands for a joint without a sample.
        let mut state = self.prior;
        for (joint, last) in self.last.iter_mut().enumerate() {
            last.age += T::one();
            if let Some(angle) = measured[joint] {
                let difference = (angle - last.angle) / (last.age * self.period_s);
                let speed = before.dq[joint];
                state.q[joint] = angle;
                state.dq[joint] = speed + self.share * (difference - speed);
                *last = Sample::new(angle);
            }
        }
        self.estimate = state;
        state
    }

    /// See [`Estimator::advance`](super::Estimator::advance).
    pub fn advance(&mut self, torque: Vector2<T>) -> State<T> {
        self.prior = self.model.step(&self.estimate, torque);
        self.prior
    }
}

impl<T: Real> Sample<T> {
    fn new(angle: T) -> Self {
        let age = T::zero();
        Self { angle, age }
    }
}
