//! `armbridge diff`: where two logs differ.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_client::stdio;
use armbridge_log::inspect::{Diff, Head, Log};
use armbridge_log::log_path::find;
use clap::Args;

use super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge diff runs/before runs/after
  armbridge diff a.mcap b.mcap --json

Exit codes: 0 equal, 1 different.";

/// Two logs to compare.
#[derive(Args, Debug)]
pub(crate) struct DiffArgs {
    /// Log, or run folder with a run.mcap.
    #[arg(value_name = "A")]
    pub(crate) a: PathBuf,
    /// Log to compare it with.
    #[arg(value_name = "B")]
    pub(crate) b: PathBuf,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &DiffArgs) -> Outcome {
    let load = |path: &PathBuf| Log::load(&find(Some(path), Path::new(DEFAULT_BASE))?);
    let [a, b] = [load(&args.a)?, load(&args.b)?];
    let diff = Diff::compare(&a, &b);
    let text = if args.json {
        serde_json::to_string(&diff)?
    } else {
        diff.table()
    };
    for Head { path, damage, .. } in [&a.head, &b.head] {
        for damage in damage {
            stdio::note(format_args!("{}: {damage}", path.display()));
        }
    }
    stdio::print_line(text.trim_end())?;
    Ok(ExitCode::from(u8::from(!diff.is_same())))
}
