//! Runs and their analysis: scenarios, plan execution, plots, controller analysis and
//! identification of an arm.
//!
//! | module                  | contents                                                     |
//! |-------------------------|--------------------------------------------------------------|
//! | [`scenario`]            | files that describe a run                                    |
//! | [`plan_runner`]         | a host that performs a plan step by step                     |
//! | [`run`]                 | a run from its plan to its folder                            |
//! | [`run_page`]            | the page of a run: moving arm, curves, events                |
//! | [`run_folder`]          | the folder of a run                                          |
//! | [`monte_carlo`]         | runs on many virtual arms, evaluated with the true arm       |
//! | [`sweep`]               | a scenario with every combination of several values          |
//! | [`taught_motion`]       | a motion along which a hand led the arm                      |
//! | [`plot`]                | plots of a run                                               |
//! | [`design`]              | a set-up's gain, poles, margins and step response            |
//! | [`identify`]            | identification of an arm's model from logs                   |
//! | [`levenberg_marquardt`] | least squares of functions that are not linear               |
//! | [`pendulum`]            | identification of a real servo on a pendulum                 |
//! | [`html`]                | parts of pages                                               |
#![forbid(unsafe_code)]

pub mod design;
pub mod html;
pub mod identify;
pub mod levenberg_marquardt;
pub mod monte_carlo;
pub mod pendulum;
pub mod plan_runner;
pub mod plot;
pub mod progress;
pub mod run;
pub mod run_folder;
pub mod run_page;
pub mod scenario;
pub mod sweep;
pub mod taught_motion;
#[cfg(test)]
mod test_log;
