//! Replay of a log: its inputs through the code that ran on the board, compared with the
//! recorded outputs.
//!
//! ```text
//! events -> Replayer -> inputs in their order -> bridge::app_core::Core -> records
//!                                                        |
//!           recorded records -------------------------> compare -> Report
//! ```
//!
//! Raw counts, alarms and timing come from the records, commands from the host's
//! frames, at the moments of their acknowledgements. Every output of every record and
//! every reply to a command is compared bit for bit. A replay with other settings shows
//! the board's reaction to them, open-loop: the arm's motion is the recorded one.
//!
//! A tick is not compared where an input before it is missing. Comparison resumes
//! where the board restarts: with a hello, with arming, after bring-up.
//!
//! | module    | contents                                                      |
//! |-----------|---------------------------------------------------------------|
//! | `replayer` | events in, ticks out; state of the knowledge about the board |
//! | `board`   | the core that boards run, with the inputs of records          |
//! | `tick_facts` | facts from one record                                      |
//! | `pending` | messages beside records, and their places in the order        |
//! | `compare` | two records, field by field                                   |
//! | `report`  | result of a replay                                            |
//! | `what_if` | other settings, and their effect                              |

mod board;
mod compare;
mod loss;
mod pending;
mod replayer;
mod report;
mod tick_facts;
mod what_if;

pub use compare::Difference;
pub use replayer::{ReplayError, Replayer};
pub use report::{Adopted, Report, Skipped, Verdict};
pub use what_if::{ChangeError, Changes, JointChange, WhatIf};
