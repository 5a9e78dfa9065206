//! One file per command, and what they have in common.

pub(crate) mod demo;
pub(crate) mod emulate;
pub(crate) mod servos;

mod job;

/// How a command ends: with an exit code, or with a line for the user.
pub(crate) type Outcome = Result<std::process::ExitCode, Box<dyn std::error::Error>>;
