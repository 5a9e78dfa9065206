//! Recomputation of the paper's numbers and figures by the code that the board runs, and a
//! page with a verdict on each claim.
//!
//! The paper describes the arm, its model and its controllers, and states
//! numbers that do not all follow from one another. Each module computes the numbers
//! of one part of the paper with the library and makes [`Claim`]s of them; a claim's
//! verdict is computed from those numbers and stated thresholds. The text of the page is
//! formatted around the computed numbers, so it cannot differ from the run.
//!
//! | module            | part of the paper                                         |
//! |-------------------|-----------------------------------------------------------|
//! | `dynamics`        | (1) to (4): energy, equilibria                            |
//! | `discrete_model`  | (7)                                                       |
//! | `pwm`             | (5)                                                       |
//! | `gains`           | (10), (12)                                                |
//! | `free_fall`       | Fig. 5                                                    |
//! | `constant_input`  | Fig. 6                                                    |
//! | `regulation`      | Figs. 7 and 8                                             |
//! | `lqr_observer`    | "the ensemble becomes unstable"                           |
//! | `tracking`        | Figs. 9 and 10                                            |
//! | `report`          | the page; `json` is the same for programs                 |
//!
//! They share [`identification`] (section 3: its procedure, for logs of a board as
//! well), `sampled_loop` (the sampled loop on the simulated arm), `stability` (its linear
//! theory), `observers`, `computed_torque` (the tracking law), and `printed` (the printed
//! numbers). The paper shows its measured curves without data: where it compares with its
//! arm, the simulated arm with dry friction is used instead.
#![forbid(unsafe_code)]

mod chart;
mod claim;
mod computed_torque;
mod constant_input;
mod discrete_model;
mod dynamics;
mod free_fall;
mod gains;
pub mod identification;
mod json;
mod lqr_observer;
mod observers;
mod printed;
mod pwm;
mod regulation;
mod report;
mod sampled_loop;
mod stability;
mod text;
mod tracking;

pub use chart::Figure;
pub use claim::{Claim, Number, Rule, Verdict};
pub use constant_input::ConstantInput;
pub use discrete_model::DiscreteModel;
pub use dynamics::Dynamics;
pub use free_fall::FreeFall;
pub use gains::Gains;
pub use json::JsonReport;
pub use lqr_observer::{LqrObserver, WEAK};
pub use pwm::PwmLaw;
pub use regulation::Regulation;
pub use report::{table, write};
pub use tracking::{OMEGA, Tracking};

use armbridge_control::design::{placement, riccati};
use armbridge_control::estimate;
use armbridge_servo::JOINTS;

/// The board's usual period in µs.
pub(crate) const BOARD_US: u32 = 1000;

pub(crate) const JOINT_NAMES: [&str; JOINTS] = ["Joint 1", "Joint 2"];

/// Reason why the paper's own numbers give no design; only a defect of the library can
/// cause one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// No LQR gain.
    #[error("no LQR gain for the paper's model: {0:?}")]
    Riccati(riccati::Error),
    /// No observer gain.
    #[error("no observer gain for the paper's poles: {0:?}")]
    Placement(placement::Error),
    /// No estimator.
    #[error("no estimator for the paper's period: {0:?}")]
    Estimate(estimate::Error<f64>),
    /// No pairing of the printed poles.
    #[error("no pairing of the paper's poles")]
    Pairing,
}

impl From<riccati::Error> for DesignError {
    fn from(error: riccati::Error) -> Self {
        Self::Riccati(error)
    }
}

impl From<placement::Error> for DesignError {
    fn from(error: placement::Error) -> Self {
        Self::Placement(error)
    }
}

impl From<estimate::Error<f64>> for DesignError {
    fn from(error: estimate::Error<f64>) -> Self {
        Self::Estimate(error)
    }
}

/// All results of the run.
#[derive(Clone, Debug)]
pub struct Findings {
    /// (1) to (4).
    pub dynamics: Dynamics,
    /// (7).
    pub discrete_model: DiscreteModel,
    /// (10) and (12).
    pub gains: Gains,
    /// Fig. 5.
    pub free_fall: FreeFall,
    /// Fig. 6.
    pub constant_input: ConstantInput,
    /// (5).
    pub pwm: PwmLaw,
    /// Figs. 7 and 8.
    pub regulation: Regulation,
    /// LQR on the printed observer.
    pub lqr_observer: LqrObserver,
    /// Figs. 9 and 10.
    pub tracking: Tracking,
}

impl Findings {
    /// Computes all results in some seconds, with up to four threads.
    ///
    /// # Errors
    ///
    /// See [`DesignError`].
    pub fn compute() -> Result<Self, DesignError> {
        // The slow parts do not depend on each other.
        std::thread::scope(|scope| {
            let free_fall = scope.spawn(FreeFall::compute);
            let lqr_observer = scope.spawn(LqrObserver::compute);
            let tracking = scope.spawn(Tracking::compute);
            Ok(Self {
                dynamics: Dynamics::compute(),
                discrete_model: DiscreteModel::compute(),
                gains: Gains::compute()?,
                constant_input: ConstantInput::compute(),
                pwm: PwmLaw::compute(),
                regulation: Regulation::compute()?,
                free_fall: join(free_fall),
                lqr_observer: join(lqr_observer)?,
                tracking: join(tracking)?,
            })
        })
    }

    /// All claims in the paper's order.
    pub fn claims(&self) -> Vec<Claim> {
        [
            self.dynamics.claims(),
            self.discrete_model.claims(),
            self.free_fall.claims(),
            self.constant_input.claims(),
            self.pwm.claims(),
            self.gains.claims(),
            self.regulation.claims(),
            self.lqr_observer.claims(),
            self.tracking.claims(),
        ]
        .concat()
    }
}

fn join<T>(thread: std::thread::ScopedJoinHandle<'_, T>) -> T {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
