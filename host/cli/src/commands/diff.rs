//! `armbridge diff`: where logs differ.

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge_client::stdio;
use armbridge_log::inspect::Diff;
use clap::Args;

use super::plot::AlignName;
use super::{Outcome, log};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge diff runs/before runs/after
  armbridge diff a.mcap b.mcap c.mcap --align setpoint --json

Each run is compared with the first, at the same times after the event of
--align. Where periods differ, the ticks of the slower run count: angles and
speeds of the faster one are interpolated there.

Exit codes: 0 equal, 1 different.";

/// Logs to compare.
#[derive(Args, Debug)]
pub(crate) struct DiffArgs {
    /// Logs, or run folders with a run.mcap; each is compared with the first.
    #[arg(value_name = "LOG", num_args = 2.., required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Event at which times are aligned.
    #[arg(long, value_name = "EVENT", default_value = "drive")]
    pub(crate) align: AlignName,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &DiffArgs) -> Outcome {
    let paths: Result<Vec<_>, _> = args.logs.iter().map(|log| log::find(Some(log))).collect();
    let diff = Diff::read(&paths?, args.align.into())?;
    let text = if args.json {
        serde_json::to_string(&diff)?
    } else {
        diff.table()
    };
    for damage in &diff.damage {
        stdio::note(format_args!("{damage}"));
    }
    stdio::print_line(text.trim_end())?;
    Ok(ExitCode::from(u8::from(!diff.is_same())))
}
