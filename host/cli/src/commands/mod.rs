//! One file per command, and what they have in common.

pub(crate) mod arm;
pub(crate) mod bench;
pub(crate) mod calibrate;
pub(crate) mod config;
pub(crate) mod demo;
pub(crate) mod design;
pub(crate) mod diff;
#[cfg(unix)]
pub(crate) mod emulate;
pub(crate) mod export;
pub(crate) mod get;
pub(crate) mod identify;
pub(crate) mod info;
pub(crate) mod link;
#[cfg(feature = "live")]
pub(crate) mod live;
pub(crate) mod off;
pub(crate) mod paper;
pub(crate) mod plot;
pub(crate) mod replay;
pub(crate) mod run;
pub(crate) mod scan;
pub(crate) mod servo;
pub(crate) mod servos;
pub(crate) mod set;
pub(crate) mod shell;
pub(crate) mod status;
pub(crate) mod torture;
pub(crate) mod watch;

mod ask;
mod bus;
mod errand;
mod job;
mod session;

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

/// The server is built where it is asked for.
#[cfg(not(feature = "live"))]
pub(crate) mod live {
    pub(crate) fn run(_: &crate::cli::LiveArgs) -> super::Outcome {
        Err("this build has no live server; `cargo build --release --features live` makes one that has".into())
    }
}
