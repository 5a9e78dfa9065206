//! The end of the program: its exit code, and its last line on standard error.
//!
//! | code          | meaning                                                           |
//! |---------------|-------------------------------------------------------------------|
//! | 0             | done                                                              |
//! | 1             | it failed on the board, on a servo or by its result               |
//! | 2             | it could not be done at all, or its result could not be printed    |
//! | 129, 130, 143 | ended by a hang-up, ctrl-C or a request to terminate; what was done is kept |
//! | 141           | the reader of standard output closed it, as `head` does           |
//!
//! The codes above 128 are those that a shell shows for a program that a signal ends: 128
//! and the signal's number. A command that runs until ctrl-C, such as `arm`, ends with 0.

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

use armbridge_client::{ctrl_c, stdio};

use crate::commands::Outcome;

/// The command could not be carried out.
pub(crate) const IMPOSSIBLE: u8 = 2;

/// 128 and the number of `SIGPIPE`.
const CLOSED: u8 = 141;

/// The exit code of a command; its error is written on standard error.
pub(crate) fn code(outcome: Outcome) -> ExitCode {
    // Buffered output must be written before its success is known.
    let outcome = match (outcome, stdio::Stdout.flush()) {
        (Ok(code), Err(error)) if code == ExitCode::SUCCESS => Err(error.into()),
        // The command has failed already, with a reason of its own.
        (outcome, _) => outcome,
    };
    match outcome {
        _ if stdio::is_closed() => ExitCode::from(CLOSED),
        Ok(code) => code,
        // The terminal that it would be printed on is gone.
        Err(_) if stdio::has_failed() && ctrl_c::is_raised() => ExitCode::from(ctrl_c::exit_code()),
        Err(error) => {
            stdio::note(format_args!("armbridge: {}", in_one_line(&*error)));
            ExitCode::from(if ctrl_c::is_raised() {
                ctrl_c::exit_code()
            } else {
                IMPOSSIBLE
            })
        }
    }
}

/// An error and its causes.
fn in_one_line(error: &dyn Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !line.contains(&text) {
            line = format!("{line}: {text}");
        }
        cause = error.source();
    }
    line
}
