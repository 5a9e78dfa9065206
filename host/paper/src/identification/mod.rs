//! The paper's own identification of joint 1, and the reason why it gives two values of one
//! friction.
//!
//! Section 3 fits viscous friction to a free fall, b1 = 0.421; then it pushes the arm
//! with a constant input, fits that torque and the friction together, and obtains 0.239. It
//! suspects "static friction which is not modelled". This module fits the same two
//! experiments as the paper did, and then with dry friction in the model: the two values
//! become one.
//!
//! ```text
//! samples of joint 1 -> fit, viscous only -> check of the form -> fit, dry friction
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
mod form_check;
mod joint_parameters;
mod least_squares;
mod log;
mod motion;
mod sampled_experiment;
mod table;
mod virtual_arm;

pub use super::printed::PUSH_FROM_RAD;
pub use comparison::{CompareError, Estimate, FitSummary, PaperComparison};
pub use experiment_fits::{ExperimentError, FrictionModel};
pub use fit::{Fit, FitError, fit};
pub use form_check::FormCheck;
pub use joint_parameters::{
    JointParameters, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VISCOUS_TORQUE_COULOMB,
    VISCOUS_TORQUE_INERTIA,
};
pub use log::{NoExperiment, experiments};
pub use sampled_experiment::{ExperimentKind, InitialState, SampledExperiment};
pub use virtual_arm::VirtualArm;
