//! Identification: from logs of an unknown arm to the numbers of a model, with what is
//! known of them.
//!
//! ```text
//! logs -> traces -> windows in which a joint slides -> start -> search -> numbers
//! ```
//!
//! Each joint of the arm has ten numbers ([`Quantity`]) beside static friction, and two more
//! if its dry friction falls with speed. They
//! are sought as those whose motions explain the encoders best: each window's motion is
//! computed from a start of its own, with its derivatives, and compared with the counts,
//! tick by tick. Where joints stick, motion does not depend smoothly on the numbers, and one
//! wrong number there would outweigh all other data; such moments are left out. Where
//! they turn round at once it does, and such windows show inertia and delay best. Static
//! friction is sought when all else is found, from the moments at which a joint gave way.
//!
//! Noise of a count and rounding make an error of 1.04 counts, white; so the sum of
//! squares is the likelihood, and its curvature the covariance. Where windows disagree
//! more than that, the model is not the arm, and the stated errors grow by as much.
//!
//! What is not identifiable is reported: a dead zone, for one, that ends no farther beyond
//! the motor's true zero than it begins before it.
//!
//! What motion does not determine is taken from what is known before ([`Prior`]): all torques
//! are multiples of one, and that one is the weight.
//!
//! | file        | contents                                                      |
//! |-------------|---------------------------------------------------------------|
//! | `quantity`  | the numbers, and the coordinates in which they are sought     |
//! | `arm`       | the equations of a joint in these numbers, over dual numbers  |
//! | `motion`    | a joint that slides, from tick to tick                        |
//! | `record`    | what of a log is of use                                       |
//! | `dataset`   | what was sent and measured; where joints slide                |
//! | `prior`     | what is believed before                                       |
//! | `initial_guess` | where to begin, by linear least squares                   |
//! | `cost`      | the sum of squares, its slope and curvature                   |
//! | `search`    | the way down                                                  |
//! | `stiction`  | static friction, by what a joint at rest withstood            |
//! | `stribeck`  | dry friction that falls with speed, where it does             |
//! | `stage`     | windows of one length, and dead zones tried in them           |
//! | `fit`      | all of it, round by round                                     |
//! | `diagnose`  | whether an arm is identifiable from the logs at all           |
//! | `checks`    | identifiability, residuals, form of the model                 |
//! | `forecast`  | how well the numbers predict logs that were not fitted        |
//! | `holdout`   | the same, where there is no other log                         |
//! | `outcome`   | settings of a board that has this arm                         |
//! | `report`    | the numbers as a table                                        |
//! | `acceptance` | whether they are known well enough for control               |
//! | `page`      | all of it as a page with pictures                             |

mod acceptance;
mod arm;
mod checks;
mod cost;
mod dataset;
mod diagnose;
mod fit;
mod fit_result;
mod forecast;
mod holdout;
mod initial_guess;
mod motion;
mod outcome;
mod page;
mod prior;
mod quantity;
mod record;
mod report;
mod search;
mod stage;
mod stiction;
mod stribeck;
mod stribeck_curve;

pub use acceptance::TooVague;
pub use arm::Known;
pub use checks::{Checks, Combination, Dry, Followed, Form, Pair, Whiteness, correlations, untold};
pub use dataset::Trace;
pub use diagnose::{Diagnosis, OfJoint, Push, Tally, examine, identify, judge};
pub use fit::find;
pub use fit_result::Found;
pub use forecast::{Forecast, forecast};
pub use holdout::without_the_last;
pub use initial_guess::NoStart;
pub use outcome::{NoArm, settings};
pub use page::{Page, no_numbers};
pub use quantity::{COUNT, PER_JOINT, Quantity};
pub use record::traces;
pub use report::{Number, Report};
pub use search::Prior;
pub use stiction::Static;
pub use stribeck::Stribeck;
pub use stribeck_curve::Falling;
