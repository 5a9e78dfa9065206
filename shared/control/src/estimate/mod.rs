//! The arm's state from angle samples.
//!
//! The servos report angles only; speeds must be estimated. [`Config`] selects the
//! method, [`Config::build`] designs an [`Estimator`] for one arm and period.
//!
//! An [`Estimator`] is the design: model and gains, which never change. Its state is an
//! [`Estimate`], which each call updates.
//!
//! # One tick
//!
//! Tick k begins by sending the PWM decided in tick k-1, then samples the
//! angles. With the torques that those PWM stand for, after clamp and rounding
//! ([`Command::torque_nm`](crate::actuator::Command::torque_nm)):
//!
//! ```text
//! x(k)    = correct(samples of tick k)
//! x(k+1)  = advance(torque sent in tick k)
//! u       = control law at x(k+1), sent in tick k+1
//! ```
//!
//! The controller acts on the state at the instant its torque takes effect, so
//! the input delay of one period is accounted for, not suffered.
//!
//! # Missing samples
//!
//! A joint without a sample is predicted through: its state is the model's.
//! The supervisor limits how many may follow each other.
//!
//! # Model
//!
//! All predict with the exact discretisation about upright, and with the exact
//! gravity: the part that the linear model lacks at the present angle enters as
//! a torque. So an arm that rests at a setpoint away from upright is not taken
//! for one that is being pushed. [`Kalman`] has Coriolis torque and dry friction
//! too, and finds the torque that is left.
//!
//! # Example
//!
//! An arm at rest is held against a push of 50 mN m on joint 1, which the Kalman filter finds:
//!
//! ```
//! use armbridge_control::arm::Parameters;
//! use armbridge_control::estimate::{Config, Error, Tuning};
//! use nalgebra::Vector2;
//!
//! let arm = Parameters::<f64>::paper();
//! let filter = Config::kalman().build(&arm, 1e-3).unwrap();
//! let (q, push) = (Vector2::new(0.3, -0.2), Vector2::new(0.05, 0.0));
//! let mut estimate = filter.at_rest(q);
//! for tick in 0..3_000 {
//!     // Every tenth sample of joint 2 is missing.
//!     let state = filter.correct(&mut estimate, [Some(q.x), (tick % 10 > 0).then_some(q.y)]);
//!     assert!((state.q - q).amax() < 0.01);
//!     filter.advance(&arm, &mut estimate, arm.gravity(q) - push);
//! }
//! assert!((estimate.disturbance() - push).amax() < 1e-4);
//!
//! let no_noise = Tuning { angle_rad: 0.0, ..Tuning::standing() };
//! assert_eq!(Config::Kalman(no_noise).build(&arm, 1e-3), Err(Error::Noise));
//! ```

mod error;
mod finite_difference;
mod joint_estimate;
mod kalman;
mod luenberger;
mod model;

pub use error::Error;
pub use finite_difference::FiniteDifference;
pub use joint_estimate::Estimate;
pub use kalman::{Kalman, Tuning};
pub use luenberger::{Form, Luenberger};
pub use model::Model;

use joint_estimate::{Covariance, JointEstimate};

use crate::arm::{Parameters, Posture, State};
use crate::check_word::{CheckWord, Checked};
use crate::design::placement::{self, Poles};
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Estimator and its tuning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Config<T> {
    /// Backward difference through a first-order low pass.
    FiniteDifference {
        /// Time constant of the low pass in s; 0 leaves the plain difference.
        filter_s: T,
    },
    /// Observer (11).
    Luenberger {
        /// When a sample begins to show.
        form: Form,
        /// Two poles inside the unit circle for each joint, real ones not negative, as at
        /// 45 ms, the period of the paper; they are mapped to the running period.
        poles_45ms: [Poles<T>; JOINTS],
    },
    /// Observer (11) with a gain given outright for the running period.
    Gain {
        /// When a sample begins to show.
        form: Form,
        /// The gain L of each joint on its angle and, in 1/s, on its speed; refused unless the
        /// error decays. That of equation (11) in the prediction form, and
        /// [`to_current`](placement::to_current) of it in the current form.
        gain: [[T; 2]; JOINTS],
    },
    /// Extended Kalman filter with disturbance torques.
    Kalman(Tuning<T>),
}

impl<T: Real> Config<T> {
    /// An observer that stands well from 0.5 to 45 ms with one count of sensor
    /// noise: two time constants of 15 and 16 ms per joint.
    ///
    /// Slower poles are quieter, but take dry friction for motion and soften
    /// the arm; faster ones pass more noise on to the torque.
    pub fn standing() -> Self {
        let poles = Poles::Real(T::lit(0.05), T::lit(0.06));
        Self::Luenberger {
            form: Form::Current,
            poles_45ms: [poles; JOINTS],
        }
    }

    /// The paper's gain (12) as printed, meant for 45 ms.
    pub fn paper_gain() -> Self {
        Self::Gain {
            form: Form::Prediction,
            gain: [[0.29, 0.72], [0.34, 0.34]].map(|gain| gain.map(T::lit)),
        }
    }

    /// The Kalman filter tuned for [standing](Tuning::standing).
    pub fn kalman() -> Self {
        Self::Kalman(Tuning::standing())
    }

    /// The estimator for an arm sampled every `period_s`.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn build(&self, arm: &Parameters<T>, period_s: T) -> Result<Estimator<T>, Error<T>> {
        self.build_with_load(arm, period_s, [T::zero(); JOINTS])
    }

    /// The same with load friction, dry friction in N m per N m that each joint's gears transmit,
    /// which the model of the Kalman filter alone has.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn build_with_load(
        &self,
        arm: &Parameters<T>,
        period_s: T,
        load: [T; JOINTS],
    ) -> Result<Estimator<T>, Error<T>> {
        /// The period for which the paper chose poles, in s.
        const POLE_PERIOD_S: f64 = 0.045;

        if !(period_s.is_finite() && period_s > T::zero()) {
            return Err(Error::Period);
        }
        let model = Model::of_arm(arm, period_s);
        match *self {
            Self::FiniteDifference { filter_s } => {
                if !(filter_s.is_finite() && filter_s >= T::zero()) {
                    return Err(Error::Filter);
                }
                let difference = FiniteDifference::new(model, period_s, filter_s);
                Ok(Estimator::FiniteDifference(difference))
            }
            Self::Kalman(tuning) => Kalman::with_load(arm, period_s, &tuning, load)
                .map(Estimator::Kalman)
                .ok_or(Error::Noise),
            Self::Luenberger { form, poles_45ms } => {
                let [a1, a2] = model.joints();
                let gain = |a, poles: Poles<T>| {
                    let poles = poles
                        .at_period(T::lit(POLE_PERIOD_S), period_s)
                        .map_err(Error::Placement)?;
                    placement::current_gain(a, poles).map_err(|error| match error {
                        placement::Error::Unstable => Error::Unstable(poles.dominant()),
                        other => Error::Placement(other),
                    })
                };
                let [poles_1, poles_2] = poles_45ms;
                let gains = [gain(&a1, poles_1)?, gain(&a2, poles_2)?];
                let observer = Luenberger::new(model, gains, form);
                Ok(Estimator::Luenberger(observer))
            }
            Self::Gain { form, gain } => {
                Luenberger::given(model, gain, form).map(Estimator::Luenberger)
            }
        }
    }
}

/// Any estimator's design, chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Estimator<T> {
    /// Backward difference.
    FiniteDifference(FiniteDifference<T>),
    /// Observer.
    Luenberger(Luenberger<T>),
    /// Filter with disturbance torques.
    Kalman(Kalman<T>),
}

impl<T: Checked> Checked for Estimator<T> {
    fn check(&self, sum: &mut CheckWord) {
        match self {
            Self::FiniteDifference(difference) => difference.check(sum),
            Self::Luenberger(observer) => observer.check(sum),
            Self::Kalman(filter) => filter.check(sum),
        }
    }
}

impl<T: Real> Estimator<T> {
    /// An estimate of an arm at rest at `q` at the next samples, without any other
    /// information.
    pub fn at_rest(&self, q: Vector2<T>) -> Estimate<T> {
        self.begin_at(&State::at_rest(q), Vector2::zeros())
    }

    /// An estimate that continues from that of another estimator.
    pub fn take_over(&self, other: &Estimate<T>) -> Estimate<T> {
        self.begin_at(&other.state(), other.disturbance())
    }

    fn begin_at(&self, state: &State<T>, disturbance: Vector2<T>) -> Estimate<T> {
        let (covariance, disturbance) = match self {
            Self::FiniteDifference(_) | Self::Luenberger(_) => {
                (Covariance::zero(), Vector2::zeros())
            }
            Self::Kalman(filter) => (filter.initial_covariance(), disturbance),
        };
        let joint = |joint: usize| {
            let (q, dq) = (state.q[joint], state.dq[joint]);
            JointEstimate::new(q, dq, disturbance[joint], covariance)
        };
        Estimate {
            joints: core::array::from_fn(joint),
        }
    }

    /// Takes the samples of this tick: angles in rad, `None` where one is
    /// missing. Returns the state at the sample instant.
    pub fn correct(&self, estimate: &mut Estimate<T>, measured: [Option<T>; JOINTS]) -> State<T> {
        match self {
            Self::FiniteDifference(difference) => difference.correct(estimate, measured),
            Self::Luenberger(observer) => observer.correct(estimate, measured),
            Self::Kalman(filter) => filter.correct(estimate, measured),
        }
    }

    /// Goes on to the next sample: `torque` in N m is what the servos were sent
    /// and what acts until then, `arm` the one that the estimator was built for.
    /// Returns the state there.
    pub fn advance(
        &self,
        arm: &Parameters<T>,
        estimate: &mut Estimate<T>,
        torque: Vector2<T>,
    ) -> State<T> {
        let posture = Posture::of(estimate.state().q);
        self.advance_from(arm, &posture, estimate, torque)
    }

    /// The same, for a caller who has the posture at the estimated angles already.
    pub fn advance_from(
        &self,
        arm: &Parameters<T>,
        posture: &Posture<T>,
        estimate: &mut Estimate<T>,
        torque: Vector2<T>,
    ) -> State<T> {
        match self {
            Self::FiniteDifference(difference) => {
                difference.advance(arm, posture, estimate, torque)
            }
            Self::Luenberger(observer) => observer.advance(arm, posture, estimate, torque),
            Self::Kalman(filter) => filter.advance(arm, posture, estimate, torque),
        }
    }
}
