//! What commands have in common that do one thing on a link.

use std::path::PathBuf;

use clap::Args;

use super::LinkArgs;

/// What does one thing on a link.
#[derive(Args, Clone, Debug)]
pub(crate) struct TaskArgs {
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Write everything that is said on the link as MCAP: to this file if its name
    /// ends in .mcap, otherwise to a folder of its own in this folder.
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) record: Option<PathBuf>,
    /// Print one JSON object instead of words.
    #[arg(long)]
    pub(crate) json: bool,
}
