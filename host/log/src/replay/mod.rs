//! Replay of a log: its inputs through the code that ran on the board, compared with the
//! recorded outputs.
//!
//! ```text
//! events -> Replayer -> edits and inputs in their order -> ControlLoop -> outputs
//!                                                                           |
//!           records: recorded outputs ---------------------------------> compare -> Report
//! ```
//!
//! Each record has all inputs of its tick. What edits the loop between two ticks are commands,
//! from the host's frames at the moments of their acknowledgements, and hellos. Every output of
//! every record, and every reply that depends on the loop, is compared bit for bit. Modes, which
//! the supervisor decides, are inputs of the loop by its permission. A replay with other
//! settings shows the board's reaction to them, open-loop: the arm's motion is the recorded one.
//!
//! A tick is not compared where an edit before it is missing. Comparison resumes with a
//! hello or after bring-up, where the loop restarts.
//!
//! | module    | contents                                                      |
//! |-----------|---------------------------------------------------------------|
//! | `replayer` | events in, ticks out; state of the knowledge about the board |
//! | `board`   | the control loop of the board                                 |
//! | `live`    | replay beside a recorder, and its snapshots                   |
//! | `edits`   | edits between ticks, and their places in the order            |
//! | `compare` | outputs, field by field                                       |
//! | `report`  | result of a replay                                            |
//! | `what_if` | other settings, and their effect                              |

mod board;
mod compare;
mod edits;
mod live;
mod loss;
mod replayer;
mod report;
mod what_if;

pub use compare::Difference;
pub(super) use live::LiveReplay;
pub use replayer::{ReplayError, Replayer};
pub use report::{Report, Skipped, Verdict};
pub use what_if::{ChangeError, Changes, JointChange, WhatIf};
