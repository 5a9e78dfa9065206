//! The command line of `torture`.

use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign::Kind;
use clap::{Args, ValueEnum};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge torture
  armbridge torture --seeds 10000 --json
  armbridge torture --seeds 5000 --kinds servo-reset,servo-deaf
  armbridge torture --seed 17
  armbridge torture --servos stock

An even seed is one fault, an odd one a pair. A motor counts as on for as long as
it is driven in a mode that should not, while its servo can be reached.";

/// Faults of every kind.
#[derive(Args, Debug)]
pub(crate) struct TortureArgs {
    /// How many seeds, from 0 on.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1_000,
        conflicts_with = "seed"
    )]
    pub(crate) seeds: u64,
    /// Replay this one, and tell what happens.
    #[arg(long, value_name = "SEED")]
    pub(crate) seed: Option<u64>,
    /// Of the seeds, only those with no other faults than these.
    #[arg(
        long,
        value_name = "KIND,KIND",
        value_delimiter = ',',
        conflicts_with = "seed"
    )]
    pub(crate) kinds: Vec<Kind>,
    /// Servos on the bench.
    #[arg(long, value_enum, default_value_t = ServosName::Morpheus)]
    pub(crate) servos: ServosName,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Servos by their firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ServosName {
    /// With the open firmware Morpheus.
    Morpheus,
    /// AX-12A as they come.
    Stock,
}

impl From<ServosName> for Firmware {
    fn from(name: ServosName) -> Self {
        match name {
            ServosName::Morpheus => Self::Morpheus,
            ServosName::Stock => Self::Stock,
        }
    }
}
