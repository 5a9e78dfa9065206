//! The Luenberger observer, equation (11).
//!
//! ```text
//! x-(k) = model one period after x^(k-1), under the torque that acted
//! x^(k) = x-(k) + Lc (y(k) - C x-(k))
//! ```
//!
//! With `L = A Lc` the predictions x- are those of (11), see
//! [`placement`](crate::design::placement).

use super::model::Model;
use crate::JOINTS;
use crate::arm::{Discrete, State};
use crate::design::placement;
use crate::real::Real;
use nalgebra::Vector2;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// When a sample begins to show in the estimate.
///
/// Both forms run the same recursion and predict the same next state. They
/// differ in what [`correct`](Luenberger::correct) returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Form {
    /// One period later, as printed: the estimate is made of past samples.
    Prediction,
    /// At once: the estimate contains the present sample.
    Current,
}

/// An observer whose joints do not couple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Luenberger<T> {
    model: Model<T>,
    /// Current-form gains on angle and speed, for each joint.
    gains: [Vector2<T>; JOINTS],
    form: Form,
    state: State<T>,
}

impl<T: Real> Luenberger<T> {
    /// With [current-form gains](placement::current_gain), whichever form is
    /// asked for; at rest upright.
    pub fn new(model: Model<T>, gains: [Vector2<T>; JOINTS], form: Form) -> Self {
        Self {
            model,
            gains,
            form,
            state: State::at_rest(Vector2::zeros()),
        }
    }

    /// The paper's observer: model (7) and gain (12), both as printed.
    ///
    /// (12) is not the gain for the printed poles {0.05, 0.14, 0.1, 0.03}. It
    /// is the one for {0.60, 0.75} on joint 1 and {0.65, 0.70} on joint 2, cut
    /// to two decimals: a slow observer.
    ///
    /// # Errors
    ///
    /// None in practice; (7) has a current form.
    pub fn paper() -> Result<Self, placement::Error> {
        let model = Discrete::paper();
        let [a1, a2] = model.joints();
        let gains = [
            placement::to_current(&a1, Vector2::new(T::lit(0.29), T::lit(0.72)))?,
            placement::to_current(&a2, Vector2::new(T::lit(0.34), T::lit(0.34)))?,
        ];
        Ok(Self::new(Model::linear(&model), gains, Form::Prediction))
    }

    /// See [`Estimator::reset`](super::Estimator::reset).
    pub fn reset(&mut self, q: Vector2<T>) {
        self.state = State::at_rest(q);
    }

    pub(super) fn prior(&self) -> State<T> {
        self.state
    }

    /// Goes on from this state at the next samples.
    pub(super) fn adopt(&mut self, state: State<T>) {
        self.state = state;
    }

    /// See [`Estimator::correct`](super::Estimator::correct).
    #[inline]
    pub fn correct(&mut self, measured: [Option<T>; JOINTS]) -> State<T> {
        let predicted = self.state;
        let corrected = &mut self.state;
        for (joint, gain) in self.gains.iter().enumerate() {
            if let Some(angle) = measured[joint] {
                let innovation = angle - predicted.q[joint];
                corrected.q[joint] += gain.x * innovation;
                corrected.dq[joint] += gain.y * innovation;
            }
        }
        match self.form {
            Form::Prediction => predicted,
            Form::Current => self.state,
        }
    }

    /// See [`Estimator::advance`](super::Estimator::advance).
    #[inline]
    pub fn advance(&mut self, torque: Vector2<T>) -> State<T> {
        self.state = self.model.step(&self.state, torque);
        self.state
    }
}
