//! `armbridge bench`: any set-up, on any virtual arm, for many seeds.

mod setup;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use armbridge_analysis::monte_carlo;
use armbridge_analysis::monte_carlo::{Outcome as Trialled, Run, Task, Trial};
use armbridge_analysis::plot;
use armbridge_analysis::progress::Progress;
use armbridge_log::CsvWriter;
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Pwm;
use armbridge_shared::link::message::Setup;
use armbridge_sim::plant::{PlantConfig, PlantFile, Push};
use serde::Serialize;

use super::Outcome;
use crate::cli::BenchArgs;

/// Where the arm is held at first, in rad, unless asked otherwise.
const INITIAL_RAD: [f64; JOINTS] = [0.49, -0.3];

pub(crate) fn run(args: &BenchArgs) -> Outcome {
    let trial = trial(args)?;
    let seeds = &args.seeds.0;
    let quiet = args.quiet || args.json;
    let progress = Progress::new(seeds.len() as f64, quiet);
    let recorder = recorder(args, &trial)?;
    let one = |seed| {
        // The log of the first seed alone is kept.
        let is_shown = args.plot.is_some() && seeds.first() == Some(&seed);
        let tap = recorder.as_ref().filter(|_| is_shown).map(Recorder::tap);
        let run = trial.run_heard(seed, tap)?;
        let outcome = Trialled::of(&trial, seed, &run);
        Ok::<_, monte_carlo::TrialError>((outcome, is_shown.then_some(run)))
    };
    let results = monte_carlo::for_seeds(seeds, one, |done| progress.at(done as f64))?;
    progress.finish();
    recorder.map(Recorder::finish).transpose()?;
    let (outcomes, mut runs): (Vec<_>, Vec<_>) = results.into_iter().unzip();
    if let (Some(folder), Some(run)) = (&args.plot, runs.first_mut().and_then(Option::take)) {
        write(folder, &facts(&trial, seeds[0]), &run)?;
    }
    let mut out = std::io::stdout();
    let printed = if args.json {
        let report = Report {
            trial: Described::of(&trial, args.reference),
            outcomes: &outcomes,
        };
        writeln!(out, "{}", serde_json::to_string(&report)?)
    } else if args.quiet {
        Ok(())
    } else {
        let heading = heading(args, &trial);
        writeln!(
            out,
            "{heading}\n{}",
            monte_carlo::table(&outcomes).trim_end()
        )
    };
    printed.map_err(|error| format!("cannot print the outcomes: {error}"))?;
    let is_faulty = outcomes.iter().any(|outcome| outcome.fault.is_some());
    Ok(ExitCode::from(u8::from(is_faulty)))
}

/// What is printed with `--json`.
#[derive(Serialize)]
struct Report<'a> {
    trial: Described,
    outcomes: &'a [Trialled],
}

/// What was tried.
#[derive(Serialize)]
struct Described {
    setup: Setup,
    plant: PlantFile,
    reference: Task,
    pushes: Vec<Push>,
    duration_s: f64,
    loss: f64,
    version: &'static str,
}

impl Described {
    fn of(trial: &Trial, reference: Task) -> Self {
        Self {
            setup: trial.script.setup,
            plant: PlantFile::of(&trial.plant),
            reference,
            pushes: trial.pushes.clone(),
            duration_s: trial.script.duration_us as f64 * 1e-6,
            loss: trial.loss,
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

fn trial(args: &BenchArgs) -> Result<Trial, Box<dyn std::error::Error>> {
    let file = match &args.plant {
        Some(path) => PlantFile::read(path)?,
        None => PlantFile::default(),
    };
    let mut plant = file.config(INITIAL_RAD);
    if let Some(initial) = args.initial {
        plant.initial.q = initial.into();
    }
    let setup = Setup {
        period_us: args.period_us,
        controller: setup::controller(&args.control)?,
        estimator: setup::estimator(&args.estimate)?,
        friction_nm: args.friction.unwrap_or(Setup::best().friction_nm),
        ..Setup::best()
    };
    let script = args
        .reference
        .script(setup, args.duration)
        .map_err(|s| format!("this reference takes {s} s or more; say so with --duration"))?;
    Ok(Trial {
        pushes: args.disturb.clone(),
        loss: args.loss,
        ..Trial::new(plant, script)
    })
}

fn heading(args: &BenchArgs, trial: &Trial) -> String {
    let name = |value: Option<clap::builder::PossibleValue>| {
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    };
    format!(
        "armbridge bench · simulated · {} · {} · period {} µs · {} s",
        name(clap::ValueEnum::to_possible_value(&args.control.controller)),
        name(clap::ValueEnum::to_possible_value(&args.estimate.estimator)),
        trial.script.setup.period_us,
        args.duration,
    )
}

/// Plots of a run, and its records as a table; its log has been written.
fn write(folder: &Path, facts: &RunFacts, run: &Run) -> Result<(), Box<dyn std::error::Error>> {
    let mut csv = CsvWriter::create(&folder.join("run.csv"))?;
    for record in &run.records {
        csv.record(record)?;
    }
    csv.finish()?;
    plot::draw_all(folder, facts, &run.records)?;
    Ok(())
}

/// Who writes the log of the first seed, if it is asked for.
fn recorder(
    args: &BenchArgs,
    trial: &Trial,
) -> Result<Option<Recorder>, Box<dyn std::error::Error>> {
    let (Some(folder), Some(seed)) = (&args.plot, args.seeds.0.first()) else {
        return Ok(None);
    };
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", folder.display()))?;
    let path = folder.join("run.mcap");
    Ok(Some(Recorder::create_waiting(&path, &facts(trial, *seed))?))
}

fn facts(trial: &Trial, seed: u64) -> RunFacts {
    let setup = trial.script.setup;
    let PlantConfig {
        joints,
        friction_on,
        friction,
        ..
    } = trial.plant;
    RunFacts {
        name: "bench".into(),
        world: "simulated: bench".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        seed: Some(seed),
        period_us: setup.period_us,
        setup,
        rad_per_count: joints.map(|joint| joint.rad_per_count),
        zero_count: joints.map(|joint| joint.zero_count),
        torque_limits_nm: joints.map(|joint| [joint.torque(Pwm::MIN), joint.torque(Pwm::MAX)]),
        static_friction_nm: friction_on.then(|| friction.map(|f| f.static_nm)),
        stiction_offset_mrad: None,
    }
}
