//! The paper's own identification of joint 1, and why it gives two values of one friction.
//!
//! Section 3 lets the arm fall and fits its viscous friction, b1 = 0.421; then it pushes
//! with a constant input, fits that torque and the friction together, and gets 0.239. It
//! suspects "static friction which is not modelled". Here the same two experiments are
//! fitted as the paper did, and then with dry friction in the model: the two values become
//! one.
//!
//! ```text
//! samples of joint 1 -> fit, viscous only -> is it of the right form? -> fit, dry friction
//! ```
//!
//! | file          | what lives there                                                |
//! |---------------|-----------------------------------------------------------------|
//! | `numbers`     | the arm as one joint, and what may be sought of it              |
//! | `motion`      | how it moves, with derivatives                                  |
//! | `sampled`     | an experiment's samples                                         |
//! | `virtual_arm` | the paper's two experiments, simulated                          |
//! | `log`         | the same two in a log of the board                              |
//! | `fit`         | least squares, standard errors, what cannot be told apart       |
//! | `problem`     | the residuals, and what they say of the numbers                 |
//! | `form`        | whether viscous friction alone is of the wrong form             |
//! | `both_ways`   | the fits of each experiment                                     |
//! | `comparison`  | both experiments, fitted both ways                              |
//! | `table`       | what came of it, in words                                       |
//! | `figure`      | and as a figure                                                 |

mod both_ways;
mod comparison;
mod figure;
mod fit;
mod form;
mod log;
mod motion;
mod numbers;
mod problem;
mod sampled;
mod table;
mod virtual_arm;

pub use comparison::{CompareError, Line, Model, PaperComparison, Within};
pub use fit::{Fit, FitError, fit};
pub use form::Form;
pub use log::{NoExperiment, sampled};
pub use numbers::{
    Numbers, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VISCOUS_TORQUE_COULOMB,
    VISCOUS_TORQUE_INERTIA,
};
pub use sampled::{Kind, Sampled, Start};
pub use virtual_arm::{PUSHED_FROM_RAD, VirtualArm};
