//! Output of a run: its folder, and what is printed.

use std::path::PathBuf;

use clap::Args;

/// Output of a run: its folder, and what is printed.
#[derive(Args, Clone, Debug)]
pub(crate) struct OutputArgs {
    /// Folder in which the run's own folder is created.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Add the counters: distributions per tick, records, speed.
    #[arg(long, conflicts_with_all = ["quiet", "json"])]
    pub(crate) verbose: bool,
    /// Print the summary as one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}
