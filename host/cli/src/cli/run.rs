//! Arguments of `armbridge run`.

use std::path::PathBuf;

use armbridge_sim::link::Pace;
use clap::{Args, ValueEnum};

use super::{LinkArgs, OutputArgs};

/// What the help ends with.
pub(super) const EXAMPLES: &str = "\
Examples:
  armbridge run --list                      what ships
  armbridge run upright                     on the bench, as fast as it goes
  armbridge run push --link emulate:        the same by the firmware image under QEMU
  armbridge run mine.toml --link serial:    a file of your own, on a board
  armbridge run mine.toml --check           is it in order? Nothing moves
  armbridge run hour --duration 600 --json  ten minutes, summed up as JSON

A scenario is a TOML file; `armbridge run NAME --show` prints one that ships, to start
from. Ctrl-C switches the motors off, then ends the run.

Exit codes: 0 the run ended as the scenario wants it, 1 otherwise (a fault, something
expected that was missed, records lost), 2 there was no run, 130 ended by ctrl-c.";

/// Play a scenario.
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
#[derive(Args, Clone, Debug)]
pub(crate) struct RunArgs {
    /// A file, or the name of a scenario that ships.
    #[arg(required_unless_present = "list")]
    pub(crate) scenario: Option<String>,
    /// List the scenarios that ship.
    #[arg(long, conflicts_with_all = ["scenario", "link", "out", "quiet"])]
    pub(crate) list: bool,
    /// Say whether the scenario is in order, and do nothing.
    #[arg(long)]
    pub(crate) check: bool,
    /// Print the file of a scenario that ships, and do nothing.
    #[arg(long, conflicts_with = "check")]
    pub(crate) show: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Length of the run in s instead of the scenario's own; what repeats does so until
    /// then.
    #[arg(long, value_name = "S", value_parser = super::duration)]
    pub(crate) duration: Option<f64>,
    /// Seed of the bench instead of the scenario's own.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// The virtual arm instead of the scenario's own, as host/plants/default.toml
    /// describes it.
    #[arg(long, value_name = "FILE")]
    pub(crate) plant: Option<PathBuf>,
    /// How fast time goes on sim: and emulate:.
    #[arg(long, value_enum, default_value_t = PaceName::Free)]
    pub(crate) pace: PaceName,
    /// Clear a fault that is latched on the board; see to its cause first.
    #[arg(long)]
    pub(crate) clear: bool,
    /// In the end, give stock servos back the mode and the return delay they were
    /// found with.
    #[arg(long)]
    pub(crate) release: bool,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// How fast virtual time goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PaceName {
    /// As fast as it can be computed.
    Free,
    /// As the wall clock goes.
    Real,
}

impl From<PaceName> for Pace {
    fn from(name: PaceName) -> Self {
        match name {
            PaceName::Free => Self::Free,
            PaceName::Real => Self::WallClock,
        }
    }
}
