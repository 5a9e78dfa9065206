//! The link to the board.

use std::path::PathBuf;

use armbridge_sim::link::{BoardUri, Pace};
use clap::{Args, ValueEnum};

use super::{ArmArgs, VirtualServoArgs};

/// The link to the board.
#[derive(Args, Clone, Debug)]
pub(crate) struct LinkArgs {
    /// Link to the board: usb:, serial:, `serial:///dev/ttyACM0`, serial:COM3,
    /// tcp://HOST:PORT, pty:, sim: for the simulation or emulate: for the emulator
    /// [default: `ARMBRIDGE_LINK`, or link in armbridge.toml, or sim:].
    #[arg(long, value_name = "URI")]
    pub(crate) link: Option<BoardUri>,
}

/// The link to the board, its log, and the simulated arm.
#[derive(Args, Clone, Debug)]
pub(crate) struct SessionArgs {
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Record the link's traffic as MCAP: in this file if its name ends in .mcap,
    /// otherwise in a new folder inside this one.
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) record: Option<PathBuf>,
    /// The arm of `sim:` and `emulate:`.
    #[command(flatten)]
    pub(crate) arm: ArmArgs,
    #[command(flatten)]
    pub(crate) servos: VirtualServoArgs,
}

/// Pace of virtual time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PaceName {
    /// As fast as possible.
    Free,
    /// In step with the wall clock.
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
