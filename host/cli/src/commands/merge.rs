//! `armbridge merge`: parts of a fault campaign, run apart, as one.

use std::path::PathBuf;

use armbridge_sim::fault_campaign::Campaign;
use clap::Args;

use super::fault_campaign::{print, verdict};
use super::{Error, Outcome};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge fault-campaign --seeds 0..5000 --json > part-1.json
  armbridge fault-campaign --seeds 5000..10000 --json > part-2.json
  armbridge merge part-*.json

The result is that of one campaign over all seeds, to the byte. Each seed may be in
one part. The exit code is that of the campaign.";

/// Parts of a fault campaign.
#[derive(Args, Debug)]
pub(crate) struct MergeArgs {
    /// Files that `armbridge fault-campaign --json` printed.
    #[arg(required = true, value_name = "FILE")]
    parts: Vec<PathBuf>,
    /// Print one JSON object with every case instead of the table.
    #[arg(long)]
    json: bool,
    /// No table.
    #[arg(long)]
    quiet: bool,
}

pub(crate) fn run(args: &MergeArgs) -> Outcome {
    let cases = args.parts.iter().map(|path| {
        let name = path.display();
        let text = std::fs::read_to_string(path).map_err(|e| format!("cannot read {name}: {e}"))?;
        Campaign::cases_of(&text).map_err(|e| Error::from(format!("{name}: {e}")))
    });
    let cases: Result<Vec<_>, Error> = cases.collect();
    let campaign = Campaign::new(cases?.concat())?;
    print(&campaign, args.json, args.quiet, None)?;
    Ok(verdict(&campaign))
}
