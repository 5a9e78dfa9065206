//! `armbridge sweep`: a scenario with every combination of several values, for many seeds.

use std::collections::HashSet;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use armbridge::config::Config;
use armbridge_analysis::progress::Progress;
use armbridge_analysis::run_folder::RunFolder;
use armbridge_analysis::scenario::{Scenario, ScenarioText};
use armbridge_analysis::sweep::{Axis, AxisError, Combination, RUNS_MAX, Sweep, combinations};
use armbridge_client::stdio::Stdout;
use armbridge_client::{ctrl_c, stdio};
use clap::Args;
use serde_json::json;

use super::{Error, Outcome};
use crate::args::suggestions::{axes, scenarios};
use crate::args::{OutputArgs, ScenarioArgs, ScenarioArmArgs};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge sweep demo --over seed=1..20
  armbridge sweep demo --over controller.r=[5,5],[20,20] --over seed=1..10
  armbridge sweep push --over limits.torque_nm=[1,1],[0.6,0.6]
  armbridge sweep push --over plant=default,heavy
  armbridge sweep demo --over control=paper,compensated --over seed=1..20 --json

Each --over names a parameter of the board, control, plant or seed, and its
values; lists are in brackets. Every combination is checked before anything
runs, and each run is that of armbridge run SCENARIO --set KEY=VALUE --seed N,
without a log. Table, CSV and plot are in a new folder in runs/. Ctrl-C keeps
the runs that have ended.

Exit codes: 0 every run did what the scenario describes, 1 some did not (a
fault, a missed expectation), 2 there was no run, 130 ended by ctrl-c.";

/// A scenario and the values to try.
#[derive(Args, Clone, Debug)]
pub(crate) struct SweepArgs {
    /// Scenario: a file, the name of one that ships, or - for standard input; or a motion
    /// as CSV.
    #[arg(value_parser = scenarios(), hide_possible_values = true)]
    pub(crate) scenario: String,
    /// A key and its values; may be repeated. The last key changes fastest.
    #[arg(long, value_name = "KEY=VALUE,VALUE", required = true, value_parser = axes(),
          hide_possible_values = true)]
    pub(crate) over: Vec<String>,
    #[command(flatten)]
    pub(crate) overrides: ScenarioArgs,
    #[command(flatten)]
    pub(crate) arm: ScenarioArmArgs,
    /// Write the log of each run as well.
    #[arg(long)]
    pub(crate) logs: bool,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

pub(crate) fn run(args: &SweepArgs) -> Outcome {
    let config = Config::discover()?;
    let (keys, grid, seeds) = grid(args, &config)?;
    let count = grid.len() * seeds.len();
    if !args.output.quiet {
        // Those of the other combinations differ in their values at most.
        let notes = grid.iter().map(|(_, scenario)| &scenario.notes);
        let notes = notes.filter(|notes| !notes.is_empty());
        notes.take(1).flatten().for_each(stdio::note);
    }
    ctrl_c::listen()?;
    let base = config.out(args.output.out.as_deref());
    let folder = RunFolder::create(Some(&base), &format!("sweep-{}", grid[0].1.name))?;
    let progress = Progress::new(count as f64, args.output.quiet || args.output.json);
    let begun = Instant::now();
    let logs = args.logs.then(|| folder.path());
    let (sweep, logged) = Sweep::run(keys, grid, seeds, logs, |done| {
        progress.set_position(done as f64);
        progress.set_message(format!("{done} of {count} runs"));
    });
    progress.finish();
    if sweep.runs.is_empty() {
        // Best effort: a log that ends early keeps its folder.
        let _ = std::fs::remove_dir(folder.path());
        logged?;
        return Ok(ExitCode::from(ctrl_c::exit_code()));
    }
    sweep.write_csv(&folder.file("sweep.csv"))?;
    if config.draws_plots() {
        sweep.draw(folder.path())?;
    }
    print(args, &sweep, folder.path(), begun.elapsed().as_secs_f64())?;
    let (done, path) = (sweep.runs.len(), folder.path().display());
    logged.map_err(|error| {
        format!("{error}; ended after {done} of {count} runs, which are in {path}")
    })?;
    if !sweep.is_complete() {
        let signal = ctrl_c::in_words();
        let text = format!("ended by {signal} after {done} of {count} runs; they are in {path}");
        stdio::note(format_args!("armbridge: {text}"));
        return Ok(ExitCode::from(ctrl_c::exit_code()));
    }
    let has_failed = sweep.runs.iter().any(|run| run.figures.has_failed());
    Ok(ExitCode::from(u8::from(has_failed)))
}

/// Keys, checked combinations and seeds.
type Grid = (Vec<String>, Vec<(Combination, Scenario)>, Vec<u64>);

/// Checks every combination.
fn grid(args: &SweepArgs, config: &Config) -> Result<Grid, Error> {
    let parsed: Result<Vec<Axis>, AxisError> = args.over.iter().map(|text| text.parse()).collect();
    let mut values: Vec<(String, Vec<String>)> = Vec::new();
    let (mut seeds, mut distinct) = (Vec::<u64>::new(), HashSet::new());
    for axis in parsed? {
        match axis {
            Axis::Seeds(_) if !seeds.is_empty() => {
                return Err("--over seed is given twice".into());
            }
            Axis::Seeds(more) => seeds.extend(more),
            Axis::Values(key, _) if values.iter().any(|(known, _)| *known == key) => {
                return Err(format!("--over {key} is given twice").into());
            }
            Axis::Values(key, list) => values.push((key, list)),
        }
    }
    if let Some(seed) = seeds.iter().find(|seed| !distinct.insert(**seed)) {
        return Err(AxisError::Repeated("seed".into(), seed.to_string()).into());
    }
    let common = args.overrides.overrides(&args.arm, config)?;
    let grid = combinations(&values).filter(|grid| grid.len() * seeds.len().max(1) <= RUNS_MAX);
    let grid = grid.ok_or_else(|| format!("these are more than {RUNS_MAX} runs"))?;
    let mut checked = Vec::with_capacity(grid.len());
    let source = ScenarioText::read(&args.scenario)?;
    for combination in grid {
        let overrides = combination.overrides(&common)?;
        let scenario = source
            .scenario(&overrides)
            .map_err(|error| format!("with {combination}: {error}"))?;
        checked.push((combination, scenario));
    }
    if seeds.is_empty() {
        seeds = checked
            .iter()
            .take(1)
            .map(|(_, scenario)| scenario.bench.seed)
            .collect();
    }
    let keys = values.into_iter().map(|(key, _)| key).collect();
    Ok((keys, checked, seeds))
}

fn print(args: &SweepArgs, sweep: &Sweep, folder: &Path, wall_s: f64) -> Result<(), Error> {
    let mut out = Stdout;
    if args.output.json {
        let report = json!({
            "scenario": sweep.scenario,
            "keys": sweep.keys,
            "seeds": sweep.seeds,
            "rows": sweep.rows(),
            "runs": sweep.runs,
            "combinations": sweep.combinations,
            "folder": folder,
        });
        writeln!(out, "{report}")?;
    } else if !args.output.quiet {
        let (name, done) = (&sweep.scenario, sweep.runs.len());
        let path = folder.display();
        writeln!(
            out,
            "armbridge sweep {name} · simulated · {done} runs in {wall_s:.1} s\n"
        )?;
        writeln!(out, "{}\n{path}", sweep.table())?;
    }
    Ok(())
}
