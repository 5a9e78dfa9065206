//! `armbridge trials`: trials of any set-up on any virtual arm, for many seeds.

mod args;
mod setup;

use std::path::Path;
use std::process::ExitCode;

use armbridge_analysis::monte_carlo::{Maneuver, Outcome as Trialled, Run, Trial};
use armbridge_analysis::progress::Progress;
use armbridge_analysis::{monte_carlo, plot};
use armbridge_client::{ctrl_c, stdio};
use armbridge_link::message::Setup;
use armbridge_log::CsvWriter;
use armbridge_log::output_file::OutputFile;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Row;
use armbridge_log::run_info::RunFacts;
use armbridge_servo::{JOINTS, Pwm};
use armbridge_sim::plant::{PlantConfig, PlantFile, Push};
use serde::Serialize;

use super::{Error, Outcome};
use crate::args::ForceArgs;
pub(crate) use args::TrialsArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge trials
  armbridge trials --estimator luenberger --friction 0,0 --seeds 1..20
  armbridge trials --controller computed-torque --reference sine:0.3,0.3,1
  armbridge trials --plant dead-zone --disturb 1,0.2,3,0.05 --loss 0.2

Unspecified options use the recommended settings: the LQR, the Kalman filter,
and 0.04 N m against friction. Results are of the true arm's worse joint. Ctrl-C
stops after the trials that have begun; the finished ones are printed,
and the exit code is 130.";

/// Default initial angles in rad.
const INITIAL_RAD: [f64; JOINTS] = [0.49, -0.3];

pub(crate) fn run(args: &TrialsArgs) -> Outcome {
    let trial = trial(args)?;
    let seeds = &args.seeds.0;
    let quiet = args.quiet || args.json;
    let progress = Progress::new(seeds.len() as f64, quiet);
    ctrl_c::listen()?;
    let recorder = recorder(args, &trial)?;
    let one = |seed| {
        // The log of the first seed alone is kept.
        let is_shown = args.plot.is_some() && seeds.first() == Some(&seed);
        let tap = recorder.as_ref().filter(|_| is_shown).map(Recorder::tap);
        let run = trial.run_with_tap(seed, tap)?;
        let outcome = Trialled::from_run(&trial, seed, &run);
        Ok::<_, monte_carlo::TrialError>((outcome, is_shown.then_some(run)))
    };
    let results = monte_carlo::for_seeds(seeds, one, |done| progress.set_position(done as f64))?;
    progress.finish();
    let (outcomes, mut runs): (Vec<_>, Vec<_>) = results.into_iter().unzip();
    // Printed before log and plots are written, which may fail.
    print(args, &trial, &outcomes)?;
    recorder.map(Recorder::finish).transpose()?;
    if let (Some(folder), Some(run)) = (&args.plot, runs.first_mut().and_then(Option::take)) {
        write(folder, args.force, &facts(&trial, seeds[0]), &run)?;
    }
    if outcomes.len() < seeds.len() {
        let (done, all) = (outcomes.len(), seeds.len());
        stdio::note(format_args!("armbridge: ended after {done} of {all} seeds"));
        return Ok(ExitCode::from(ctrl_c::exit_code()));
    }
    let is_faulty = outcomes.iter().any(|outcome| outcome.fault.is_some());
    Ok(ExitCode::from(u8::from(is_faulty)))
}

fn print(args: &TrialsArgs, trial: &Trial, outcomes: &[Trialled]) -> Result<(), Error> {
    if args.json {
        let report = Report {
            trial: Described::of(trial, args.reference),
            outcomes,
        };
        stdio::print_line(serde_json::to_string(&report)?)?;
    } else if !args.quiet && !outcomes.is_empty() {
        let heading = heading(args, trial);
        let table = monte_carlo::table(outcomes);
        stdio::print_line(format_args!("{heading}\n{}", table.trim_end()))?;
    }
    Ok(())
}

/// Output of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    trial: Described,
    outcomes: &'a [Trialled],
}

/// The trial.
#[derive(Serialize)]
struct Described {
    setup: Setup,
    plant: PlantFile,
    reference: Maneuver,
    pushes: Vec<Push>,
    duration_s: f64,
    loss: f64,
    version: &'static str,
}

impl Described {
    fn of(trial: &Trial, reference: Maneuver) -> Self {
        Self {
            setup: trial.script.setup,
            plant: PlantFile::from_config(&trial.plant),
            reference,
            pushes: trial.pushes.clone(),
            duration_s: trial.script.duration_us as f64 * 1e-6,
            loss: trial.loss,
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

fn trial(args: &TrialsArgs) -> Result<Trial, Error> {
    let file = match &args.plant {
        Some(name) => PlantFile::load(name)?,
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

fn heading(args: &TrialsArgs, trial: &Trial) -> String {
    let name = |value: Option<clap::builder::PossibleValue>| {
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    };
    format!(
        "armbridge trials · simulated · {} · {} · period {} µs · {} s",
        name(clap::ValueEnum::to_possible_value(&args.control.controller)),
        name(clap::ValueEnum::to_possible_value(&args.estimate.estimator)),
        trial.script.setup.period_us,
        args.duration,
    )
}

/// Plots of a run, and its records as a table; its log has been written.
fn write(folder: &Path, force: ForceArgs, facts: &RunFacts, run: &Run) -> Result<(), Error> {
    let path = folder.join("run.csv");
    let file = OutputFile::create(&path, force.chosen());
    let file = file.map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    let mut csv = CsvWriter::to(file, false)?;
    for record in &run.records {
        csv.row(&Row::from(*record))?;
    }
    csv.finish()?;
    plot::draw_all(folder, force.beside_log(), facts, &run.records)?;
    Ok(())
}

/// The recorder of the first seed, if its log is requested.
fn recorder(args: &TrialsArgs, trial: &Trial) -> Result<Option<Recorder>, Error> {
    let (Some(folder), Some(seed)) = (&args.plot, args.seeds.0.first()) else {
        return Ok(None);
    };
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", folder.display()))?;
    // Before the trials, which take long.
    args.force.check(&folder.join("run.csv"))?;
    let path = folder.join("run.mcap");
    // The trial of a seed can be repeated, and with it its log.
    args.force.make_room(&path)?;
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
        name: "trials".into(),
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
