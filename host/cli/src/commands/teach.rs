//! `armbridge teach`: a motion, by leading the arm by hand.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::run::{RunHost, Verdict};
use armbridge_analysis::run_folder::RunFolder;
use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_analysis::taught_motion::TaughtMotion;
use armbridge_client::stdio;
use armbridge_log::output_file;
use armbridge_log::recording::Recording;
use armbridge_sim::link::drive;
use armbridge_sim::plant::PlantFile;
use clap::Args;
use serde_json::json;

use super::Outcome;
use super::run::Staging;
use crate::args::suggestions::plants;
use crate::args::values::{duration, seed};
use crate::args::{ForceArgs, LinkArgs, PaceName};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge teach --out demo.csv                  a simulated arm and hand
  armbridge teach --out demo.csv --link serial:   a real one: hold it first
  armbridge run demo.csv                          replay it
  armbridge run demo.csv --speed 0.5 --repeat 3   at half its speed, three times

The arm weighs nothing from the start, and stays where it is left. Ctrl-C ends
the lesson before its time. Then motors go off, unless the board has a pose to
park the arm in (`armbridge params park`): hold the arm. Rests before
and after the motion are cut off.

Exit codes: 0 the motion is taught and can be replayed; 1 there was a fault, or
a replay would exceed the board's bounds; 2 there was no run, or the arm was not
moved.";

/// Scenario of a lesson.
const SCENARIO: &str = "teach";
/// Length of a lesson on a real arm in s.
const LESSON_S: f64 = 60.0;

/// A motion, by leading the arm by hand.
#[derive(Args, Debug)]
pub(crate) struct TeachArgs {
    /// File that the motion is written to.
    #[arg(long, value_name = "CSV", default_value = "taught.csv")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Length of the lesson in s; by default a minute, of a simulated arm that of its hand.
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Virtual arm of a simulated board: the name of one that ships (`armbridge plants`), or
    /// a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    pub(crate) plant: Option<String>,
    /// Seed of the encoder noise.
    #[arg(long, value_parser = seed)]
    pub(crate) seed: Option<u64>,
    /// Pace of time on sim: and emulate:.
    #[arg(long, value_enum, default_value_t = PaceName::Free)]
    pub(crate) pace: PaceName,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
    /// No progress bar, no text.
    #[arg(long)]
    pub(crate) quiet: bool,
}

pub(crate) fn run(args: &TeachArgs) -> Outcome {
    let config = Config::discover()?;
    let link = config.link(args.link.link.as_ref())?;
    if args
        .out
        .extension()
        .is_none_or(|extension| extension != "csv")
    {
        let file = args.out.display();
        return Err(format!("{file}: a motion is a file that ends in .csv").into());
    }
    // Refused before the lesson, not after it.
    args.force.check(&args.out)?;
    let of_link = (!link.is_simulated()).then_some(LESSON_S);
    let overrides = Overrides {
        plant: args.plant.as_deref().map(PlantFile::load).transpose()?,
        seed: args.seed,
        configured: config.control(),
        duration_s: args.duration.or(of_link),
        ..Overrides::default()
    };
    let mut scenario = Scenario::load(SCENARIO, &overrides)?;
    let staging = Staging {
        config: &config,
        link: &link,
        pace: args.pace.into(),
        is_quiet: args.quiet,
        is_silent: args.quiet || args.json,
    };
    let mut options = staging.options(&mut scenario);
    let folder = RunFolder::create(Some(&config.out(None)), SCENARIO)?;
    let mut player = RunHost::in_folder(staging.task(scenario)?, folder)?;
    options.link.taps.push(player.tap());
    options.interactions = Some(player.interactions());
    let (player, result) = drive(&link, options, player);
    let finished = player.finish(result)?;
    if finished.verdict == Verdict::Failed {
        stdio::note_text(finished.summary.table());
        return Ok(ExitCode::from(finished.verdict.exit_code()));
    }
    let taught = TaughtMotion::from_records(&Recording::load(&finished.folder)?.records())?;
    output_file::write(&args.out, taught.csv().as_bytes(), args.force.chosen())?;
    report(args, &taught, &finished.folder, &config)
}

/// Prints what was taught, and whether it can be replayed.
fn report(args: &TeachArgs, taught: &TaughtMotion, folder: &Path, config: &Config) -> Outcome {
    let file = args.out.display().to_string();
    let overrides = Overrides {
        configured: config.control(),
        ..Overrides::default()
    };
    let replay = Scenario::load(&file, &overrides);
    if args.json {
        stdio::print_line(json!({
            "motion": file,
            "duration_s": taught.duration_s(),
            "cut_s": taught.cut_s,
            "smoothed_s": taught.width_s,
            "is_clamped": taught.is_clamped,
            "can_be_replayed": replay.is_ok(),
            "folder": folder,
        }))?;
    } else if !args.quiet {
        let [before, after] = taught.cut_s;
        stdio::print_line(format_args!(
            "{file}: {:.2} s of motion, smoothed over {:.0} ms; rests of {before:.1} and {after:.1} s \
             are cut off",
            taught.duration_s(),
            taught.width_s * 1e3
        ))?;
        if taught.is_clamped {
            stdio::print_line("it was led beyond the board's range, at whose end it is held")?;
        }
        for note in replay.iter().flat_map(|scenario| &scenario.notes) {
            stdio::print_line(note)?;
        }
    }
    if let Err(why) = replay {
        stdio::note(format_args!(
            "armbridge: it cannot be replayed at this speed: {why}\nTry: armbridge run {file} \
             --speed 0.5"
        ));
        return Ok(ExitCode::from(1));
    }
    if !(args.json || args.quiet) {
        stdio::print_line(format_args!("Next: armbridge run {file}"))?;
    }
    Ok(ExitCode::SUCCESS)
}
