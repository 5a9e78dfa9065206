//! One file per command, and what they have in common.

pub(crate) mod bench;
pub(crate) mod demo;
#[cfg(unix)]
pub(crate) mod emulate;
pub(crate) mod paper;
pub(crate) mod scan;
pub(crate) mod servo;
pub(crate) mod servos;
pub(crate) mod torture;

mod bus;
mod job;

/// How a command ends: with an exit code, or with a line for the user.
pub(crate) type Outcome = Result<std::process::ExitCode, Error>;

/// A line for the user.
type Error = Box<dyn std::error::Error>;

/// QEMU's standard input and output carry the lockstep messages over a socket
/// pair, which other systems lack.
#[cfg(not(unix))]
pub(crate) mod emulate {
    pub(crate) fn run(_: &crate::cli::EmulateArgs) -> super::Outcome {
        Err("`emulate` needs Linux or macOS; `demo` runs everywhere".into())
    }
}
