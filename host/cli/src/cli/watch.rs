//! `armbridge watch`.

use clap::Args;

use super::SessionArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge watch                                   the simulated arm; r arms and regulates
  armbridge watch --link serial:                    the board that is plugged in
  armbridge watch --link tcp://127.0.0.1:7001 --record run.mcap

Keys: space stops, d disarms, q quits and disarms first, ? shows all of them.";

/// A dashboard.
#[derive(Args, Debug)]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) session: SessionArgs,
}
