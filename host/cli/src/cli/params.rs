//! The command lines of `get` and `set`.

use std::path::PathBuf;

use armbridge_client::params;
use clap::Args;
use toml::Value;

use super::LinkArgs;

pub(crate) const GET_EXAMPLES: &str = "\
Examples:
  armbridge get
  armbridge get limits controller.q --link serial:
  armbridge get --all --json

Says what the board computes with, as it tells after the hello. A group such as limits
stands for all of its parameters.";

pub(crate) const SET_EXAMPLES: &str = "\
Examples:
  armbridge set limits.hold_ms=80 controller.q=30,30,0.3,0.3 --link serial:
  armbridge set controller.kind=computed-torque controller.natural_rad_s=25,25
  armbridge set --from gains.toml --save

All changes are made, or none: the limits as one group, only while the board is idle, and
the set-up as another, without a step in the torque. Exit code 1 if the board refuses.";

/// What is asked for.
#[derive(Args, Debug)]
pub(crate) struct GetArgs {
    /// Parameters or groups of them; all if none is named.
    #[arg(value_name = "KEY")]
    pub(crate) keys: Vec<String>,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Show those of other kinds of controller and estimator as well.
    #[arg(long)]
    pub(crate) all: bool,
    /// Print one JSON array instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is to be changed.
#[derive(Args, Debug)]
pub(crate) struct SetArgs {
    /// What to change to what; lists with commas between.
    #[arg(value_name = "KEY=VALUE", value_parser = params::pair, required_unless_present = "from")]
    pub(crate) pairs: Vec<(String, Value)>,
    /// Take changes from a file with tables as in armbridge.toml, such as `design --write`
    /// makes; what is named on the command line goes first.
    #[arg(long, value_name = "FILE")]
    pub(crate) from: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Have the board keep all its settings across power-off.
    #[arg(long)]
    pub(crate) save: bool,
    /// Say what would be changed, and change nothing.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}
