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
//! | file              | contents                                                    |
//! |-------------------|-------------------------------------------------------------|
//! | `numbers`         | the arm as one joint, and what may be sought of it          |
//! | `motion`          | how it moves, with derivatives                              |
//! | `sampled`         | an experiment's samples                                     |
//! | `virtual_arm`     | the paper's two experiments, simulated                      |
//! | `log`             | the same two in a log of the board                          |
//! | `problem`         | the residuals and their derivatives                         |
//! | `fit`             | least squares, standard errors, what is not identifiable    |
//! | `form`            | whether viscous friction alone is of the wrong form         |
//! | `experiment_fits` | the fits of each experiment                                 |
//! | `comparison`      | both experiments, fitted both ways                          |
//! | `table`           | the result in words                                         |
//! | `figure`          | the result as a figure                                      |

mod comparison;
mod experiment_fits;
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

pub use super::printed::PUSH_FROM_RAD;
pub use comparison::{CompareError, Line, PaperComparison, Within};
pub use experiment_fits::{ExperimentError, Model};
pub use fit::{Fit, FitError, fit};
pub use form::Form;
pub use log::{NoExperiment, sampled};
pub use numbers::{
    Numbers, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VISCOUS_TORQUE_COULOMB,
    VISCOUS_TORQUE_INERTIA,
};
pub use sampled::{Kind, Sampled, Start};
pub use virtual_arm::VirtualArm;
