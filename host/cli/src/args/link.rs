//! The link to the board.

use std::path::PathBuf;

use armbridge_sim::link::{BoardUri, Pace};
use clap::{Args, ValueEnum};

use super::{ArmArgs, VirtualServoArgs};

/// Where the board is.
#[derive(Args, Clone, Debug)]
pub(crate) struct LinkArgs {
    /// Link to the board: usb:, serial:, `serial:///dev/ttyACM0`, tcp://HOST:PORT, pty:,
    /// sim: for the bench or emulate: for the emulator
    /// [default: `ARMBRIDGE_LINK`, or link in armbridge.toml, or sim:].
    #[arg(long, value_name = "URI")]
    pub(crate) link: Option<BoardUri>,
}

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
