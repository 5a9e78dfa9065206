//! `armbridge disarm`, `stop` and `clear`.

use std::io::Write;
use std::process::ExitCode;

use armbridge::tasks::off::{Clear, Disarm, Stop};
use armbridge::tasks::{Task, TaskHost};
use armbridge_client::names;
use armbridge_client::trip;
use armbridge_shared::link::message::Mode;
use armbridge_sim::link::{BoardUri, Pace};
use serde_json::json;

use super::{Outcome, errand};
use crate::cli::ErrandArgs;

pub(crate) fn disarm(args: &ErrandArgs) -> Outcome {
    let (uri, host) = errand::go(args, "disarm", Pace::Free, Disarm::default())?;
    let is_fault = matches!(host.session.status().mode(), Some(Mode::Fault(_)));
    let said = host.session.status().trip.filter(|_| is_fault).map_or_else(
        || "disarmed: motors are off".to_owned(),
        |tripped| {
            let account = trip::in_words(&tripped);
            format!(
                "motors are off; a fault is latched: {}; {}",
                account.cause, account.advice
            )
        },
    );
    print_result(args, &uri, &host, &said)
}

pub(crate) fn stop(args: &ErrandArgs) -> Outcome {
    let (uri, host) = errand::go(args, "stop", Pace::Free, Stop::default())?;
    let cause = host
        .session
        .status()
        .trip
        .map(|trip| trip::in_words(&trip).cause);
    let said = format!(
        "stopped: {}; `armbridge clear` clears it when the arm is free to move",
        cause.unwrap_or_default()
    );
    print_result(args, &uri, &host, &said)
}

pub(crate) fn clear(args: &ErrandArgs) -> Outcome {
    let (uri, host) = errand::go(args, "clear", Pace::Free, Clear::default())?;
    print_result(args, &uri, &host, "no fault is latched; motors are off")
}

fn print_result<T: Task>(
    args: &ErrandArgs,
    uri: &BoardUri,
    host: &TaskHost<T>,
    said: &str,
) -> Outcome {
    let mut out = std::io::stdout();
    if args.json {
        let mode = host.session.status().mode();
        let report = json!({
            "link": uri.to_string(),
            "mode": mode.map(names::mode),
            "fault": mode.and_then(names::fault_of).map(names::fault),
            "in_words": said,
        });
        writeln!(out, "{report}")?;
    } else {
        writeln!(out, "{said}")?;
    }
    Ok(ExitCode::SUCCESS)
}
