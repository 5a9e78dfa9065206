//! The commands, one file each with its arguments, and what several have in common.

pub(crate) mod arm;
pub(crate) mod calibrate;
pub(crate) mod clear;
pub(crate) mod completions;
pub(crate) mod config;
pub(crate) mod design;
pub(crate) mod diff;
pub(crate) mod disarm;
pub(crate) mod doctor;
pub(crate) mod export;
pub(crate) mod fault_campaign;
pub(crate) mod foxglove;
pub(crate) mod hand;
pub(crate) mod identify;
pub(crate) mod info;
pub(crate) mod man;
pub(crate) mod merge;
pub(crate) mod paper;
pub(crate) mod params;
pub(crate) mod plants;
pub(crate) mod plot;
pub(crate) mod push;
pub(crate) mod replay;
pub(crate) mod run;
pub(crate) mod scan;
pub(crate) mod serve;
pub(crate) mod servo;
pub(crate) mod setup;
pub(crate) mod status;
pub(crate) mod stop;
pub(crate) mod sweep;
pub(crate) mod teach;
pub(crate) mod trials;
pub(crate) mod watch;

mod ask;
mod bus;
mod finish;
mod interruptible;
mod link;
mod log;
mod motors_off;
mod params_exchange;
mod recording;
mod session;
mod task;
mod terminal_guide;
mod touch;
mod transparent_port;
mod virtual_arm;

/// Result of a command: an exit code, or a line for the user.
pub(crate) type Outcome = Result<std::process::ExitCode, Error>;

/// A line for the user.
type Error = Box<dyn std::error::Error>;
