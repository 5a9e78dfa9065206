//! Runs a task on a link, for commands that do one thing.

use std::process::ExitCode;

use armbridge::board_tasks::{Task, TaskHost};
use armbridge::config::Config;
use armbridge_client::{LinkError, ctrl_c, enum_names, stdio};
use armbridge_link::message::Fault;
use armbridge_sim::link::{BoardUri, Options, Pace, drive};
use serde_json::json;

use super::recording::Recording;
use super::{Error, Outcome, link};
use crate::args::TaskArgs;

/// Runs the task; returns the link's name and the host.
pub(crate) fn go<T: Task>(
    args: &TaskArgs,
    name: &str,
    pace: Pace,
    task: T,
) -> Result<(BoardUri, TaskHost<T>), Error> {
    let config = Config::discover()?;
    let (uri, mut options) = link::options(&args.link, &config)?;
    options.pace = pace;
    options.link.intent = task.intent();
    let recording = record(args, name, &uri, &mut options)?;
    ctrl_c::listen()?;
    let (host, result) = drive(&uri, options, TaskHost::new(task));
    let written = recording.map(Recording::finish).transpose();
    match result {
        Ok(()) => {}
        Err(LinkError::Link(error)) => return Err(error),
        Err(LinkError::Host(why)) => {
            let link = uri.to_string();
            // Some links end in a colon of their own.
            return Err(format!("{}: {why}", link.trim_end_matches(':')).into());
        }
    }
    if let Some(trouble) = written?.and_then(|report| report.trouble) {
        return Err(format!("the log is not complete: {trouble}").into());
    }
    Ok((uri, host))
}

fn record(
    args: &TaskArgs,
    name: &str,
    uri: &BoardUri,
    options: &mut Options,
) -> Result<Option<Recording>, Error> {
    let Some(path) = &args.record else {
        return Ok(None);
    };
    let recording = Recording::begin(path, name, &uri.world())?;
    options.link.taps.extend(recording.taps());
    Ok(Some(recording))
}

/// Prints the result.
pub(crate) fn print<T: Task>(
    args: &TaskArgs,
    uri: &BoardUri,
    host: &TaskHost<T>,
    message: &str,
) -> Outcome {
    if args.json {
        let mode = host.session.status().mode();
        let report = json!({
            "link": uri.to_string(),
            "mode": mode.map(enum_names::mode),
            "fault": mode.and_then(enum_names::fault_of).map(Fault::name),
            "in_words": message,
        });
        stdio::print_line(report)?;
    } else {
        stdio::print_line(message)?;
    }
    Ok(ExitCode::SUCCESS)
}
