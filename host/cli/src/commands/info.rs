//! `armbridge info`: what a log holds.

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge_client::stdio;
use armbridge_log::inspect::Info;
use clap::Args;

use super::{Outcome, log};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge info
  armbridge info runs/2026-11-21T10-55-00Z-demo
  armbridge info run.mcap --json";

/// A log to summarise.
#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// Log, or run folder with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// Print one JSON object instead of the text.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &InfoArgs) -> Outcome {
    let info = Info::read(&log::find(args.log.as_deref())?)?;
    let text = if args.json {
        serde_json::to_string(&info)?
    } else {
        info.table()
    };
    stdio::print_line(text.trim_end())?;
    Ok(ExitCode::SUCCESS)
}
