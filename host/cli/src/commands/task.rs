//! Runs a task on a link, for commands that do one thing.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge::board_tasks::{Task, TaskHost};
use armbridge::config::Config;
use armbridge_analysis::run_folder::RunFolder;
use armbridge_client::LinkError;
use armbridge_client::ctrl_c;
use armbridge_client::enum_names;
use armbridge_client::stdio;
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_shared::link::message::Settings;
use armbridge_sim::link::{BoardUri, Options, Pace, drive};
use serde_json::json;

use super::Outcome;
use super::{Error, link};
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
    let recorder = record(args, name, &uri, &mut options)?;
    ctrl_c::listen()?;
    let (host, result) = drive(&uri, options, TaskHost::new(task));
    let written = recorder.map(Recorder::finish).transpose();
    match result {
        Ok(()) => {}
        Err(LinkError::Link(error)) => return Err(error),
        Err(LinkError::Host(why)) => return Err(format!("{uri}: {why}").into()),
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
) -> Result<Option<Recorder>, Error> {
    let Some(path) = &args.record else {
        return Ok(None);
    };
    let facts = RunFacts::from_settings(name, &uri.world(), &Settings::default());
    let recorder = Recorder::create(&log_file(path, name)?, &facts)?;
    options.link.taps.push(recorder.tap());
    Ok(Some(recorder))
}

/// The log's path: this file, or one in a new folder under this one.
pub(super) fn log_file(path: &Path, name: &str) -> Result<PathBuf, Error> {
    if path
        .extension()
        .is_some_and(|extension| extension == "mcap")
    {
        return Ok(path.into());
    }
    let folder = RunFolder::create(Some(path), name)?;
    stdio::note(format_args!("recording in {}", folder.path().display()));
    Ok(folder.file("run.mcap"))
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
            "fault": mode.and_then(enum_names::fault_of).map(enum_names::fault),
            "in_words": message,
        });
        stdio::print_line(report)?;
    } else {
        stdio::print_line(message)?;
    }
    Ok(ExitCode::SUCCESS)
}
