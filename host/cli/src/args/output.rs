//! What is written and shown of a run.

use std::path::PathBuf;

use clap::Args;

/// What is written and shown of a run.
#[derive(Args, Clone, Debug)]
pub(crate) struct OutputArgs {
    /// Folder in which the run folder is made.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Print the summary as one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}
