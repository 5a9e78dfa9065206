//! `armbridge torture`: the fault campaign on the bench.

use std::convert::Infallible;
use std::io::Write;
use std::process::ExitCode;

use armbridge_analysis::monte_carlo;
use armbridge_analysis::progress::Progress;
use armbridge_sim::fault_campaign;
use armbridge_sim::fault_campaign::{Case, Report};

use super::Outcome;
use crate::cli::TortureArgs;

pub(crate) fn run(args: &TortureArgs) -> Outcome {
    let (report, text) = match args.seed {
        Some(seed) => {
            let (outcome, story) = fault_campaign::run_with_story(seed, args.servos.into());
            (Report::of(&[outcome]), Some(story))
        }
        None => (campaign(args), None),
    };
    let text = if args.json {
        serde_json::to_string(&report)? + "\n"
    } else if args.quiet {
        String::new()
    } else {
        text.unwrap_or_else(|| fault_campaign::table(&report))
    };
    let mut out = std::io::stdout();
    write!(out, "{text}").map_err(|error| format!("cannot print the report: {error}"))?;
    Ok(ExitCode::from(u8::from(!report.holds())))
}

/// Of the seeds from 0 on, those whose faults are all asked for.
fn campaign(args: &TortureArgs) -> Report {
    let servos = args.servos.into();
    let is_wanted = |seed: &u64| {
        let is_kind = |kind| args.kinds.is_empty() || args.kinds.contains(&kind);
        let case = Case::new(*seed, servos);
        case.injections
            .iter()
            .all(|injection| is_kind(injection.kind))
    };
    let seeds: Vec<u64> = (0..args.seeds).filter(is_wanted).collect();
    let progress = Progress::new(seeds.len() as f64, args.quiet || args.json);
    let one = |seed| Ok::<_, Infallible>(fault_campaign::run(seed, servos));
    let outcomes = monte_carlo::for_seeds(&seeds, one, |done| progress.at(done as f64));
    progress.finish();
    Report::of(&outcomes.unwrap_or_else(|never| match never {}))
}
