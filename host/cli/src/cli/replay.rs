//! The command line of `replay`.

use std::path::PathBuf;

use armbridge_client::params;
use clap::Args;
use toml::Value;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge replay
  armbridge replay runs/2026-01-31T12-00-00Z-demo
  armbridge replay board.mcap --json
  armbridge replay --with gains.toml
  armbridge replay --set controller.q=[40,40,1,1] --set limits.torque_nm=[0.5,0.5]

Raw counts, commands, parameters and timing of the log go through the code that ran
on the board; every output of every tick must be the same, to the bit. Exit code: 0
the same, 1 not, 2 it cannot be told. With other settings the log tells what the
board would have done instead, open-loop: the arm's answers stay as recorded.";

/// The board's code on a log's inputs.
#[derive(Args, Debug)]
pub(crate) struct ReplayArgs {
    /// Log file or run folder; by default the newest in `runs`.
    pub(crate) log: Option<PathBuf>,
    /// Settings to replay with instead of the recorded ones: a TOML file with any of
    /// the parameters that `armbridge config --explain` lists.
    #[arg(long, value_name = "TOML")]
    pub(crate) with: Option<PathBuf>,
    /// The same, one parameter at a time.
    #[arg(long, value_name = "KEY=VALUE", value_parser = params::pair)]
    pub(crate) set: Vec<(String, Value)>,
    /// Print one JSON object instead of the text.
    #[arg(long)]
    pub(crate) json: bool,
}
