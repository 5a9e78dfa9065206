//! A log's inputs through the code that ran on the board, and whether it says the
//! same again.
//!
//! ```text
//! events -> Replayer -> order of what happened -> bridge::app_core::Core -> records
//!                                                        |
//!           recorded records -------------------------> compare -> Report
//! ```
//!
//! Raw counts, alarms and timing come from the records, orders from the host's
//! frames, at the moments at which the board says it took them. Every output of
//! every record is compared bit for bit, and every answer to a command. The same
//! with other settings tells what the board would have done instead, as far as that
//! can be told: the arm's answers are those to what it did.
//!
//! A tick is not compared where something before it is missing. Comparison goes on
//! where the board began anew: with a hello, with arming, after bring-up.
//!
//! | module    | what                                                          |
//! |-----------|---------------------------------------------------------------|
//! | `replayer`  | events in, ticks out; what is known of the board              |
//! | `board`   | the core that boards run, with the inputs of records          |
//! | `tick_facts`   | what one record shows of the board                            |
//! | `pending`   | what the board told beside records, and where it belongs      |
//! | `compare` | two records, field by field                                   |
//! | `report`  | what became of it                                             |
//! | `what_if` | other settings, and what differs then                         |

mod board;
mod compare;
mod pending;
mod replayer;
mod report;
mod tick_facts;
mod what_if;

pub use compare::Difference;
pub use replayer::{ReplayError, Replayer};
pub use report::{Adopted, Report, Skipped, Verdict};
pub use what_if::{ChangeError, Changes, JointChange, WhatIf};
