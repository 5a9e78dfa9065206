//! Arguments of commands that do one thing on a link.

use std::path::PathBuf;

use clap::Args;

use super::LinkArgs;

/// The link of a command that does one thing on it.
#[derive(Args, Clone, Debug)]
pub(crate) struct TaskArgs {
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Record the link's traffic as MCAP: in this file if its name ends in .mcap,
    /// otherwise in a new folder inside this one.
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) record: Option<PathBuf>,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}
