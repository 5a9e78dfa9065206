//! Identification: estimates the parameters of an arm's model from logs, with confidence
//! intervals.
//!
//! ```text
//! logs -> traces -> windows in which a joint slides -> initial guess -> search -> estimates
//! ```
//!
//! Each joint has ten parameters ([`Quantity`]) beside static friction, two more if it has a
//! Stribeck curve, and one more if its dry friction grows with the load on its gears. Their
//! estimates minimise the residuals of the encoders: the motion of each window is computed from an initial state of its own, with its derivatives, and
//! compared with the counts, tick by tick. Where a joint sticks, its motion does not depend
//! smoothly on the parameters, and one wrong parameter would outweigh all other data; such
//! moments are left out. Where it reverses at once, the motion is smooth, and such windows
//! are the most informative about inertia and delay. Static friction is estimated after all
//! others, from the breakaways.
//!
//! Noise of a count and rounding make a white residual of 1.04 counts, so the sum of squares
//! is the likelihood, and its curvature the covariance. Where windows disagree by more, the
//! model is not the arm, and the standard errors grow accordingly.
//!
//! Unidentifiable parameters are reported: for one, a dead zone that ends no farther beyond
//! the motor's true neutral than it begins before it.
//!
//! The prior ([`Prior`]) supplies the parameters that motion does not determine: it
//! determines torques only up to a common factor, which the arm's weight fixes.
//!
//! | file             | contents                                                       |
//! |------------------|----------------------------------------------------------------|
//! | `quantity`       | the parameters, and the coordinates of the search               |
//! | `arm`            | the equations of motion of a joint, over dual numbers           |
//! | `motion`         | motion of a sliding joint, tick by tick                         |
//! | `record`         | traces of a log                                                 |
//! | `dataset`        | PWM and encoder counts; windows in which a joint slides         |
//! | `prior`          | prior means and standard deviations                             |
//! | `initial_guess`  | initial guess by linear least squares                           |
//! | `cost`           | sum of squares, its gradient and Hessian                        |
//! | `search`         | Levenberg-Marquardt                                             |
//! | `stiction`       | static friction, from breakaways                                |
//! | `friction_forms` | forms of dry friction beside Coulomb's: which a joint has       |
//! | `profile`        | loss over the parameters of such a form, the others fitted      |
//! | `load`           | fit of load friction                                            |
//! | `stribeck`       | fit of a Stribeck curve                                         |
//! | `stribeck_curve` | the curve                                                       |
//! | `stage`          | windows of one length, and the dead zones fitted in them        |
//! | `fit`            | all stages of the fit                                           |
//! | `fit_result`     | parameters, covariance, windows                                 |
//! | `diagnose`       | whether the logs identify an arm at all                         |
//! | `checks`         | identifiability, whiteness of residuals, model errors           |
//! | `forecast`       | prediction of logs excluded from the fit                        |
//! | `holdout`        | prediction of windows excluded from a second fit                |
//! | `board_settings` | settings of a board with the identified arm                     |
//! | `report`         | the estimates as a table                                        |
//! | `arm_fit`        | the fit of an arm to logs, with its report and checks           |
//! | `plausible_arms` | virtual arms drawn from the distribution of the estimates        |
//! | `acceptance`     | whether the estimates are certain enough for control            |
//! | `page`           | the report as a page with figures                               |

mod acceptance;
mod arm;
mod arm_fit;
mod board_settings;
mod checks;
mod cost;
mod dataset;
mod diagnose;
mod fit;
mod fit_result;
mod forecast;
mod friction_forms;
mod holdout;
mod initial_guess;
mod load;
mod motion;
mod page;
mod plausible_arms;
mod prior;
mod profile;
mod quantity;
mod record;
mod report;
mod search;
mod stage;
mod stiction;
mod stribeck;
mod stribeck_curve;

pub use crate::html::PAGE_NAME;
pub use acceptance::UncertainParameter;
pub use arm::KnownParameters;
pub use arm_fit::{AdoptError, ArmFit, ArmFitError, FitData};
pub use board_settings::{UnphysicalArm, identified_settings};
pub use checks::{
    Checks, Combination, Correlation, MissingTorque, Rollout, Whiteness, WithoutDryFriction,
};
pub use dataset::Trace;
pub use diagnose::{Diagnosis, JointTally, Tally, check_data, check_fit, identify};
pub use fit_result::FitResult;
pub use forecast::{Forecast, forecast};
pub use holdout::holdout_forecasts;
pub use load::LoadEstimate;
pub use page::{Page, write_diagnosis};
pub use prior::Prior;
pub use quantity::{COUNT, PER_JOINT, Quantity};
pub use record::traces;
pub use report::{Estimate, Report};
pub use stiction::StaticFriction;
pub use stribeck::StribeckEstimate;
pub use stribeck_curve::StribeckCurve;
