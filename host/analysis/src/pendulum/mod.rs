//! Identification of one real servo on a pendulum, from recordings in the format of the project
//! BAM (Better Actuator Models).
//!
//! ```text
//! recordings -> simulation, controller in the loop -> search -> errors, holdouts, intervals
//! ```
//!
//! A servo drives a rigid pendulum by its own position controller, towards goals that a host
//! sends. A recording is simulated from its goals alone: from the first sample on, no measured
//! angle enters. The error is the mean absolute difference of the simulated angle and the
//! measured one, over all samples, in degrees; it is also what the fit minimises.
//!
//! Gears of small servos rub the more, the more torque they transmit. So three forms of dry
//! friction ([`FrictionForm`]) are fitted and compared. Their errors on recordings that a fit
//! has not seen ([`Holdout`]) tell whether further parameters describe the servo or only the
//! recordings.
//!
//! What the model lacks makes residuals that last for seconds, far from white noise. The
//! intervals of the parameters are therefore from a jackknife over whole recordings.
//!
//! Angles are in rad and 0 where the pendulum hangs; torques are those at the output shaft.
//!
//! | file                    | contents                                                    |
//! |-------------------------|-------------------------------------------------------------|
//! | `recording`             | the public format                                           |
//! | `parameters`            | the parameters, and the coordinates of the search           |
//! | `model`                 | equation of motion, friction, the servo's controller        |
//! | `covariance_adaptation` | the search: CMA-ES                                          |
//! | `fit`                   | fit of a form of friction to recordings                     |
//! | `jackknife`             | 95 % intervals                                              |
//! | `holdout`               | errors on recordings excluded from the fit                  |
//! | `filter`                | the board's Kalman filter over the recordings               |
//! | `report`                | all fits of a set of recordings, as a table and as data     |

mod covariance_adaptation;
mod filter;
mod fit;
mod holdout;
mod jackknife;
mod model;
mod parameters;
mod recording;
mod report;

pub use filter::Innovations;
pub use fit::{Fit, error_deg};
pub use holdout::{Holdout, HoldoutError};
pub use jackknife::Estimate;
pub use model::simulate;
pub use parameters::{FrictionForm, Parameters, Quantity};
pub use recording::{Fault, Recording, RecordingError, Sample};
pub use report::{FormErrors, PendulumError, RecordingErrors, Report, identify};
