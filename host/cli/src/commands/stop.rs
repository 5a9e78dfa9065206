//! `armbridge stop`: the emergency stop.

use std::process::ExitCode;

use armbridge::board_tasks::TaskError;
use armbridge::board_tasks::motors_off::{Goal, MotorsOff};
use armbridge::config::Config;
use armbridge_client::fault_text;
use armbridge_client::stdio;
use armbridge_client::transport::stop_socket::{self, StopAnswer};
use armbridge_sim::link::{BoardUri, Pace};
use serde_json::json;

use super::{Error, Outcome, task};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge stop --link serial:
  armbridge stop --link tcp://127.0.0.1:7001

The stop is sent at once, without waiting for the board's hello, and repeated until the
board reports it. The fault stays latched: `armbridge clear` clears it. While another
armbridge has the link, the stop goes to that program, which sends it; a board that is
served on a socket takes it from any connection. If a program hangs, use the switch at the
board, or the one in the servos' supply.";

/// Remedy where no stop can be sent.
const OTHERWISE: &str = "nothing was stopped: use the stop switch at the board, or the switch of \
                         the servos' supply";

pub(crate) fn run(args: &TaskArgs) -> Outcome {
    let uri = Config::discover()?.link(args.link.link.as_ref())?;
    if let BoardUri::Link(link) = &uri
        && let Some(answer) = stop_socket::ask(link)
    {
        return by_the_owner(args, &uri, answer);
    }
    let (uri, host) = task::go(args, "stop", Pace::Free, MotorsOff::new(Goal::Stop))
        .map_err(|error| with_remedy(&*error))?;
    let cause = host
        .session
        .status()
        .trip
        .map(|trip| fault_text::in_words(&trip).cause);
    let message = format!(
        "stopped: {}; `armbridge clear` clears it when the arm is free to move",
        cause.unwrap_or_default()
    );
    task::print(args, &uri, &host, &message)
}

/// Reports what the program did that has the link.
fn by_the_owner(args: &TaskArgs, uri: &BoardUri, answer: StopAnswer) -> Outcome {
    match answer {
        StopAnswer::Stopped(fault) => {
            let message =
                format!("stopped by the program that has {uri}: the board reports {fault}");
            if args.json {
                let link = uri.to_string();
                let report =
                    json!({"link": link, "mode": "fault", "fault": fault, "in_words": message});
                stdio::print_line(report)?;
            } else {
                stdio::print_line(message)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        StopAnswer::Failed(reason) => {
            let error = format!("{uri} is in use by another program: {reason}");
            Err(with_remedy(&*Error::from(error)))
        }
    }
}

fn with_remedy(error: &dyn std::error::Error) -> Error {
    let error = error.to_string();
    // It has the remedy.
    if error.ends_with(&TaskError::NotStopped.to_string()) {
        return error.into();
    }
    let no_sockets = if cfg!(unix) {
        ""
    } else {
        "; on this system a stop cannot be passed on to a program that has the link"
    };
    format!("{error}{no_sockets}; {OTHERWISE}").into()
}
