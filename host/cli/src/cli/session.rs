//! A board that is served for as long as somebody looks.

use std::path::PathBuf;

use clap::Args;

use super::{ArmArgs, LinkArgs, VirtualServoArgs};

/// Which board, and whether a log is written.
#[derive(Args, Clone, Debug)]
pub(crate) struct SessionArgs {
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Write everything that is said on the link to this file, as MCAP.
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// The arm of `sim:` and `emulate:`.
    #[command(flatten)]
    pub(crate) arm: ArmArgs,
    #[command(flatten)]
    pub(crate) servos: VirtualServoArgs,
}
