//! The link of a command's `--link`, or the configured one.

use armbridge::config::Config;
use armbridge_client::transport::Intent;
use armbridge_client::{Host, ctrl_c};
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardUri, Options, drive};
use armbridge_sim::plant::{Plant, PlantConfig};

use super::Error;
use crate::args::LinkArgs;

/// Seed of the virtual servos' noise, where a command does not ask for one.
const SEED: u64 = 1;

/// The link, and what it is opened with: on `sim:` and `emulate:`, the default arm.
pub(crate) fn options(args: &LinkArgs, config: &Config) -> Result<(BoardUri, Options), Error> {
    let link = config.link(args.link.as_ref())?;
    let bench = Bench::new(Plant::new(PlantConfig::default(), SEED));
    let mut options = Options::new(bench);
    options.link.patience = config.patience();
    options.is_stoppable = true;
    Ok((link, options))
}

/// Runs a host on the link until it is done, or ctrl-c is pressed.
pub(crate) fn run_host<H>(
    args: &LinkArgs,
    config: &Config,
    intent: Intent,
    host: H,
) -> Result<H, Error>
where
    H: Host,
    H::Error: std::error::Error + 'static,
{
    let (link, mut options) = options(args, config)?;
    options.link.intent = intent;
    ctrl_c::listen()?;
    let (host, result) = drive(&link, options, host);
    result.map_err(|error| format!("{link}: {error}"))?;
    Ok(host)
}
