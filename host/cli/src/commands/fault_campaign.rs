//! `armbridge fault-campaign`: faults of every kind on the bench.

use std::convert::Infallible;
use std::ops::Range;
use std::process::ExitCode;

use armbridge_analysis::monte_carlo;
use armbridge_analysis::progress::Progress;
use armbridge_client::{ctrl_c, stdio};
use armbridge_servo::Firmware;
use armbridge_sim::fault_campaign;
use armbridge_sim::fault_campaign::{Activity, Campaign, Case, Kind};
use clap::{Args, ValueEnum};

use super::{Error, Outcome};
use crate::args::values::seed;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge fault-campaign
  armbridge fault-campaign --seeds 10000 --json
  armbridge fault-campaign --seeds 10000..20000 --json > part-2.json
  armbridge fault-campaign --seeds 5000 --kinds servo-reset,servo-deaf
  armbridge fault-campaign --seed 17
  armbridge fault-campaign --servos stock
  armbridge fault-campaign --seeds 5000 --activity float
  armbridge fault-campaign --seeds 10000 --park

An even seed is one fault, an odd one a pair. What the board does follows from the
seed too, but --activity gives it to all: only so the arm floats. A motor counts as on while it is
driven in a mode that must not drive it and its servo can be reached. Contact is
the speed at which the arm meets the table, far the time for which it is driven
0.5 rad from its reference. The exit code is 1 if a case failed, whether boards
detect its kind or not.";

/// Faults of every kind.
#[derive(Args, Debug)]
pub(crate) struct FaultCampaignArgs {
    /// Seeds from A to B - 1, or N seeds from 0 on.
    #[arg(
        long,
        value_name = "A..B or N",
        value_parser = seeds,
        default_value = "1000",
        conflicts_with = "seed"
    )]
    pub(crate) seeds: Range<u64>,
    /// Run only this seed, and print its events.
    #[arg(long, value_name = "SEED", value_parser = seed)]
    pub(crate) seed: Option<u64>,
    /// Run only seeds whose faults are all of these kinds.
    #[arg(
        long,
        value_name = "KIND,KIND",
        value_delimiter = ',',
        conflicts_with = "seed"
    )]
    pub(crate) kinds: Vec<Kind>,
    /// Run only seeds with servos of this firmware; x: every seed, with servos of the X series.
    #[arg(long, value_enum)]
    pub(crate) servos: Option<ServosName>,
    /// The board does this in every case, instead of what the seed has it do.
    #[arg(long, value_name = "ACTIVITY")]
    pub(crate) activity: Option<Activity>,
    /// The arm has a pose to be parked in, drawn from the seed.
    #[arg(long)]
    pub(crate) park: bool,
    /// Print one JSON object with every case instead of the table, also for `armbridge merge`.
    #[arg(long)]
    pub(crate) json: bool,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Servos by their firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ServosName {
    /// The open firmware Morpheus.
    Morpheus,
    /// The vendor's, on an AX-12A as sold.
    Stock,
    /// The vendor's, on servos of the X series.
    X,
}

impl From<ServosName> for Firmware {
    fn from(name: ServosName) -> Self {
        match name {
            ServosName::Morpheus => Self::Morpheus,
            ServosName::Stock => Self::Stock,
            ServosName::X => Self::XSeries,
        }
    }
}

/// Seeds as a range, or as their number.
fn seeds(text: &str) -> Result<Range<u64>, String> {
    let number = |text: &str| {
        let error = |_| format!("`{text}` is no number of seeds; expected N or A..B");
        text.parse::<u64>().map_err(error)
    };
    let range = match text.split_once("..") {
        Some((from, to)) => number(from)?..number(to)?,
        None => 0..number(text)?,
    };
    if range.is_empty() {
        return Err(format!("there are no seeds in `{text}`"));
    }
    Ok(range)
}

pub(crate) fn run(args: &FaultCampaignArgs) -> Outcome {
    ctrl_c::listen()?;
    let (outcomes, seeds, text) = if let Some(seed) = args.seed {
        let case = case(args, seed);
        let (outcome, story) = fault_campaign::run_with_trace(&case);
        (vec![outcome], 1, Some(story))
    } else {
        let (outcomes, seeds) = campaign(args);
        (outcomes, seeds, None)
    };
    let done = outcomes.len();
    let campaign = Campaign::new(outcomes)?;
    print(&campaign, args.json, args.quiet, text)?;
    if done < seeds {
        stdio::note(format_args!(
            "armbridge: ended after {done} of {seeds} seeds"
        ));
        return Ok(ExitCode::from(ctrl_c::exit_code()));
    }
    Ok(verdict(&campaign))
}

/// Prints a campaign, or this text instead of its table.
pub(super) fn print(
    campaign: &Campaign,
    json: bool,
    quiet: bool,
    text: Option<String>,
) -> Result<(), Error> {
    let text = if json {
        campaign.to_json()?
    } else if quiet {
        String::new()
    } else {
        text.unwrap_or_else(|| fault_campaign::table(&campaign.report))
    };
    Ok(stdio::print(text)?)
}

/// Exit code of a campaign.
pub(super) fn verdict(campaign: &Campaign) -> ExitCode {
    ExitCode::from(u8::from(!campaign.report.holds()))
}

/// The case of a seed, changed as requested.
fn case(args: &FaultCampaignArgs, seed: u64) -> Case {
    let case = Case::with_activity(seed, args.activity);
    let case = match args.servos {
        Some(ServosName::X) => case.with_x_servos(),
        Some(ServosName::Morpheus | ServosName::Stock) | None => case,
    };
    if args.park { case.with_pose() } else { case }
}

/// Runs the seeds whose faults are all of the requested kinds, with the requested servos;
/// returns the finished ones, and the number of all.
fn campaign(args: &FaultCampaignArgs) -> (Vec<fault_campaign::Outcome>, usize) {
    let servos: Option<Firmware> = args.servos.map(Into::into);
    let is_wanted = |seed: &u64| {
        let is_kind = |kind| args.kinds.is_empty() || args.kinds.contains(&kind);
        let case = case(args, *seed);
        let mut injections = case.injections.iter();
        servos.is_none_or(|servos| case.servos() == servos)
            && injections.all(|injection| is_kind(injection.kind))
    };
    let seeds: Vec<u64> = args.seeds.clone().filter(is_wanted).collect();
    let progress = Progress::new(seeds.len() as f64, args.quiet || args.json);
    let one = |seed| {
        let case = case(args, seed);
        Ok::<_, Infallible>(fault_campaign::run(&case))
    };
    let outcomes = monte_carlo::for_seeds(&seeds, one, |done| progress.set_position(done as f64));
    progress.finish();
    let outcomes = outcomes.unwrap_or_else(|never| match never {});
    (outcomes, seeds.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_a_number_or_a_range() {
        assert_eq!((seeds("12"), seeds("3..7")), (Ok(0..12), Ok(3..7)));
        for text in ["", "7..3", "0", "3..", "a..b", "-1"] {
            assert!(seeds(text).is_err(), "{text}");
        }
    }
}
