//! The Luenberger observer, equation (11).
//!
//! ```text
//! x-(k) = model one period after x^(k-1), under the torque that acted
//! x^(k) = x-(k) + Lc (y(k) - C x-(k))
//! ```
//!
//! With `L = A Lc` the predictions x- are those of (11), see
//! [`placement`].

use super::error::Error;
use super::joint_estimate::Estimate;
use super::model::Model;
use crate::arm::{Discrete, Parameters, Posture, State};
use crate::check_word::{CheckWord, Checked, checked};
use crate::design::{placement, stability};
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Vector2};
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// When a sample begins to show in the estimate.
///
/// Both forms run the same recursion and predict the same next state. They
/// differ in what [`correct`](Luenberger::correct) returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
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
}

checked!(Luenberger<T> { model, gains, form });

impl Checked for Form {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(match self {
            Self::Prediction => 0,
            Self::Current => 1,
        });
    }
}

impl<T: Real> Luenberger<T> {
    /// With [current-form gains](placement::current_gain), whichever form is
    /// asked for.
    pub fn new(model: Model<T>, gains: [Vector2<T>; JOINTS], form: Form) -> Self {
        Self { model, gains, form }
    }

    /// With gains given outright, see [`Config::Gain`](super::Config::Gain).
    ///
    /// # Errors
    ///
    /// [`Error::Unstable`] unless the error decays, [`Error::Placement`] for a gain that is
    /// not finite or has no current form.
    pub fn given(model: Model<T>, gains: [[T; 2]; JOINTS], form: Form) -> Result<Self, Error<T>> {
        let joints = model.joints();
        let [first, second] = gains.map(Vector2::from);
        let gains = [
            stable_current(&joints[0], first, form)?,
            stable_current(&joints[1], second, form)?,
        ];
        Ok(Self::new(model, gains, form))
    }

    /// Current-form gains on angle and speed, for each joint.
    pub fn gains(&self) -> [Vector2<T>; JOINTS] {
        self.gains
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

    /// See [`Estimator::correct`](super::Estimator::correct).
    #[inline]
    pub fn correct(&self, estimate: &mut Estimate<T>, measured: [Option<T>; JOINTS]) -> State<T> {
        let predicted = estimate.state();
        let joints = estimate.joints.iter_mut().zip(&self.gains);
        for ((joint, gain), measured) in joints.zip(measured) {
            if let Some(angle) = measured {
                let innovation = angle - joint.q;
                joint.q += gain.x * innovation;
                joint.dq += gain.y * innovation;
            }
        }
        match self.form {
            Form::Prediction => predicted,
            Form::Current => estimate.state(),
        }
    }

    /// See [`Estimator::advance`](super::Estimator::advance).
    #[inline]
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

/// The current form of a joint's gain, if the error of its predictions decays by
/// `A (1 - Lc C)`.
fn stable_current<T: Real>(
    a: &Matrix2<T>,
    gain: Vector2<T>,
    form: Form,
) -> Result<Vector2<T>, Error<T>> {
    let current = match form {
        Form::Current => gain,
        Form::Prediction => placement::to_current(a, gain).map_err(Error::Placement)?,
    };
    let by_sample = a * current;
    let error = a - Matrix2::new(by_sample.x, T::zero(), by_sample.y, T::zero());
    let eigenvalue = stability::dominant(&error);
    let eigenvalue = eigenvalue.ok_or(Error::Placement(placement::Error::NotFinite))?;
    if eigenvalue.radius() < T::one() {
        Ok(current)
    } else {
        Err(Error::Unstable(eigenvalue))
    }
}
