//! Every number and figure of the paper that simulation can give, found by the
//! code that the board runs, and a page with each claim's verdict.
//!
//! The paper describes the arm, its model and its controllers, and states
//! numbers that do not all follow from one another. Each module finds the numbers
//! of one part of it with the library and makes [`Claim`]s of them; a claim's
//! verdict is computed from those numbers and stated thresholds. The page's text is
//! written around them, so that nothing on it is older than its run.
//!
//! | module      | of the paper                                              |
//! |-------------|-----------------------------------------------------------|
//! | `model`     | (1) to (4): energy, equilibria                            |
//! | `linear`    | (7)                                                       |
//! | `pwm`       | (5)                                                       |
//! | `gains`     | (10), (12)                                                |
//! | `fall`      | Fig. 5                                                    |
//! | `push`      | Fig. 6                                                    |
//! | `standing`  | Figs. 7 and 8                                             |
//! | `hanging`   | "the ensemble becomes unstable"                           |
//! | `track`     | Figs. 9 and 10                                            |
//! | `report`    | the page; `outline` is the same for programs              |
//!
//! They share [`identification`] (section 3: its procedure, for logs of a board as
//! well), `sim` (the sampled loop on the bench's arm), `stability` (its linear
//! theory), `observers`, `tracking` (the law), and `printed` (what the paper prints).
//! Its measured curves exist on paper only: where the paper compares with its arm,
//! the bench's arm stands in, with dry friction.

pub(crate) mod chart;
mod claim;
mod fall;
mod gains;
mod hanging;
pub mod identification;
mod linear;
mod model;
mod observers;
mod outline;
pub(crate) mod printed;
mod push;
mod pwm;
mod report;
mod sim;
mod stability;
mod standing;
mod text;
mod track;
mod tracking;

pub use chart::Figure;
pub use claim::{Claim, Number, Rule, Verdict};
pub use fall::Fall;
pub use gains::Gains;
pub use hanging::{Hanging, WEAK};
pub use linear::Linear;
pub use model::Model;
pub use outline::Outline;
pub use push::Push;
pub use pwm::PwmLaw;
pub use report::{table, write};
pub use standing::Standing;
pub use track::{OMEGA, Track};

use armbridge_shared::JOINTS;
use armbridge_shared::design::{placement, riccati};
use armbridge_shared::estimate;

/// The board's usual period in µs.
pub(crate) const BOARD_US: u32 = 1000;

pub(crate) const JOINT_NAMES: [&str; JOINTS] = ["Joint 1", "Joint 2"];

/// Why the paper's own numbers give no design. It takes a change of the library
/// to see one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FindError {
    /// No LQR gain.
    #[error("no LQR gain for the paper's model: {0:?}")]
    Riccati(riccati::Error),
    /// No observer gain.
    #[error("no observer gain for the paper's poles: {0:?}")]
    Placement(placement::Error),
    /// No estimator.
    #[error("no estimator for the paper's period: {0:?}")]
    Estimate(estimate::Error),
    /// No pairing of the printed poles.
    #[error("no pairing of the paper's poles")]
    Pairing,
}

impl From<riccati::Error> for FindError {
    fn from(error: riccati::Error) -> Self {
        Self::Riccati(error)
    }
}

impl From<placement::Error> for FindError {
    fn from(error: placement::Error) -> Self {
        Self::Placement(error)
    }
}

impl From<estimate::Error> for FindError {
    fn from(error: estimate::Error) -> Self {
        Self::Estimate(error)
    }
}

/// Everything that the run finds.
#[derive(Clone, Debug)]
pub struct Findings {
    /// (1) to (4).
    pub model: Model,
    /// (7).
    pub linear: Linear,
    /// (10) and (12).
    pub gains: Gains,
    /// Fig. 5.
    pub fall: Fall,
    /// Fig. 6.
    pub push: Push,
    /// (5).
    pub pwm: PwmLaw,
    /// Figs. 7 and 8.
    pub standing: Standing,
    /// LQR on the printed observer.
    pub hanging: Hanging,
    /// Figs. 9 and 10.
    pub track: Track,
}

impl Findings {
    /// Finds everything; takes some seconds, on as many cores as there are.
    ///
    /// # Errors
    ///
    /// See [`FindError`].
    pub fn find() -> Result<Self, FindError> {
        // The slow parts do not depend on each other.
        std::thread::scope(|scope| {
            let fall = scope.spawn(Fall::find);
            let hanging = scope.spawn(Hanging::find);
            let track = scope.spawn(Track::find);
            Ok(Self {
                model: Model::find(),
                linear: Linear::find(),
                gains: Gains::find()?,
                push: Push::find(),
                pwm: PwmLaw::find(),
                standing: Standing::find()?,
                fall: joined(fall),
                hanging: joined(hanging)?,
                track: joined(track)?,
            })
        })
    }

    /// All claims, in the paper's order.
    pub fn claims(&self) -> Vec<Claim> {
        [
            self.model.claims(),
            self.linear.claims(),
            self.fall.claims(),
            self.push.claims(),
            self.pwm.claims(),
            self.gains.claims(),
            self.standing.claims(),
            self.hanging.claims(),
            self.track.claims(),
        ]
        .concat()
    }
}

fn joined<T>(thread: std::thread::ScopedJoinHandle<'_, T>) -> T {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
