//! Runs and what is made of them: scenarios, plans and their performance, plots, design of
//! controllers, identification of an arm, and the paper that the arm is from.
//!
//! | module          | what                                                         |
//! |-----------------|--------------------------------------------------------------|
//! | [`scenario`]    | what an arm is to do, as a file                              |
//! | [`plan_runner`] | a host that works through a plan step by step                |
//! | [`run`]         | a run from its plan to its folder                            |
//! | [`run_folder`]  | the folder of a run                                          |
//! | [`monte_carlo`] | the same run on many virtual arms, judged by the true arm    |
//! | [`plot`]        | plots of a run                                               |
//! | [`design`]      | a set-up's gain, poles, margins and step response            |
//! | [`identify`]    | from logs of an unknown arm to the numbers of its model      |
//! | [`paper`]       | the paper's numbers and figures, found anew                  |
#![forbid(unsafe_code)]

pub mod design;
mod html;
pub mod identify;
pub mod monte_carlo;
pub mod paper;
pub mod plan_runner;
pub mod plot;
pub mod progress;
pub mod run;
pub mod run_folder;
pub mod scenario;
