//! The link to the board, as every command that needs one is told.

use armbridge_sim::link::BoardUri;
use clap::Args;

/// Where the board is.
#[derive(Args, Clone, Debug)]
pub(crate) struct LinkArgs {
    /// Link to the board: usb:, serial:, `serial:///dev/ttyACM0`, tcp://HOST:PORT, pty:,
    /// sim: for the bench or emulate: for the emulator
    /// [default: `ARMBRIDGE_LINK`, or link in armbridge.toml, or sim:].
    #[arg(long, value_name = "URI")]
    pub(crate) link: Option<BoardUri>,
}
