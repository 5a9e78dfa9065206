//! Whether a listener is exposed to the network.

use armbridge_client::endpoint::Exposure;
use clap::Args;

/// Whether a listener is exposed to the network.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ExposeArgs {
    /// Listen on an address of the network as well: any host of it can then command the arm.
    /// Without this only programs of this machine can connect.
    #[arg(long)]
    expose: bool,
}

impl From<ExposeArgs> for Exposure {
    fn from(args: ExposeArgs) -> Self {
        if args.expose {
            Self::Network
        } else {
            Self::Loopback
        }
    }
}
