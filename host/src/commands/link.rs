//! The link that a command was told, or the one that is configured.

use armbridge::bench::Bench;
use armbridge::bench::cosim::Host;
use armbridge::bench::plant::{Plant, PlantConfig};
use armbridge::config::Config;
use armbridge::interrupt;
use armbridge::links::{LinkUri, Options, drive};

use super::Error;
use crate::cli::LinkArgs;

/// Seed of the virtual servos' noise, where a command does not ask for one.
const SEED: u64 = 1;

/// The link, and what it is opened with: on `sim:` and `emulate:`, the default arm.
pub(crate) fn options(args: &LinkArgs, config: &Config) -> Result<(LinkUri, Options), Error> {
    let link = config.link(args.link.as_ref())?;
    let bench = Bench::new(Plant::new(PlantConfig::default(), SEED));
    let mut options = Options::new(bench);
    options.patience = config.patience();
    Ok((link, options))
}

/// Runs a host on the link until it is done, or ctrl-c is pressed.
pub(crate) fn run_host<H>(args: &LinkArgs, config: &Config, host: H) -> Result<H, Error>
where
    H: Host,
    H::Error: std::error::Error + 'static,
{
    let (link, options) = options(args, config)?;
    interrupt::listen()?;
    let (host, result) = drive(&link, options, host);
    result.map_err(|error| format!("{link}: {error}"))?;
    Ok(host)
}
