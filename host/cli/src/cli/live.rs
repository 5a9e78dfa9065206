//! `armbridge live`.

use std::net::{IpAddr, Ipv4Addr};

use clap::Args;

use super::SessionArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge live                                    the simulated arm, on ws://127.0.0.1:8765
  armbridge live --link serial: --record run.mcap   the board that is plugged in, and a log
  armbridge live --allow-arm                        viewers may let the motors come on

Open the address that it prints in Foxglove (Open connection, Foxglove WebSocket).
Parameters are edited in its Parameters panel; /stop, /disarm and /clear_fault are called
from its Service Call panel, with {} as the request. Ends with ctrl-c, disarmed.";

/// Port that viewers look for.
const PORT: u16 = 8765;

/// A live server.
#[derive(Args, Debug)]
pub(crate) struct LiveArgs {
    #[command(flatten)]
    pub(crate) session: SessionArgs,
    /// Port of the server; 0 for any that is free.
    #[arg(long, default_value_t = PORT)]
    pub(crate) port: u16,
    /// Address to listen on. On any but this computer's own, whoever reaches it can
    /// change settings and stop the arm.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    pub(crate) host: IpAddr,
    /// Let viewers arm the board and have it hold the arm, or move it upright.
    #[arg(long)]
    pub(crate) allow_arm: bool,
}
