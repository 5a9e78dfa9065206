//! `armbridge bench`: any set-up, on any virtual arm, for many seeds.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use armbridge::bench::plant::{PlantConfig, PlantFile};
use armbridge::facts::RunFacts;
use armbridge::log::{CsvWriter, McapWriter};
use armbridge::plot;
use armbridge::progress::Progress;
use armbridge::trial::{self, Outcome as Trialled, Run, Trial};
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Pwm;
use armbridge_shared::estimate::{Config, Form, Tuning};
use armbridge_shared::link::message::{Controller, Gains, Setup};
use serde::Serialize;

use super::Outcome;
use crate::cli::{BenchArgs, ControllerName, EstimatorName};

/// Where the arm is held at first, in rad, unless asked otherwise.
const INITIAL_RAD: [f64; JOINTS] = [0.49, -0.3];
/// Time constant of the low pass in s that makes differences at 1 kHz usable.
const FILTER_S: f32 = 0.02;
/// Computed torque that tracks well at 1 kHz and stays quiet.
const NATURAL_RAD_S: f32 = 20.0;

pub(crate) fn run(args: &BenchArgs) -> Outcome {
    let trial = trial(args)?;
    let seeds = &args.seeds.0;
    let quiet = args.quiet || args.json;
    let progress = Progress::new(seeds.len() as f64, quiet);
    let one = |seed| {
        let run = trial.run(seed)?;
        let outcome = Trialled::of(&trial, seed, &run);
        // The log of the first seed alone is kept.
        let is_shown = args.plot.is_some() && seeds.first() == Some(&seed);
        Ok::<_, trial::TrialError>((outcome, is_shown.then_some(run)))
    };
    let results = trial::for_seeds(seeds, one, |done| progress.at(done as f64))?;
    progress.finish();
    let (outcomes, mut runs): (Vec<_>, Vec<_>) = results.into_iter().unzip();
    if let (Some(folder), Some(run)) = (&args.plot, runs.first_mut().and_then(Option::take)) {
        write(folder, &facts(&trial, seeds[0]), &run)?;
    }
    let mut out = std::io::stdout();
    let printed = if args.json {
        let report = Report {
            trial: Described::of(&trial),
            outcomes: &outcomes,
        };
        writeln!(out, "{}", serde_json::to_string(&report)?)
    } else if args.quiet {
        Ok(())
    } else {
        let heading = heading(args, &trial);
        writeln!(out, "{heading}\n{}", trial::table(&outcomes).trim_end())
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
    duration_s: f64,
    loss: f64,
    version: &'static str,
}

impl Described {
    fn of(trial: &Trial) -> Self {
        Self {
            setup: trial.script.setup,
            plant: PlantFile::of(&trial.plant),
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
        controller: controller(args)?,
        estimator: estimator(args)?,
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

fn controller(args: &BenchArgs) -> Result<Controller, String> {
    use ControllerName::{ComputedTorque, Lqr, Paper};
    let is = |name| args.controller == name;
    belongs(
        args.q.is_some() || args.r.is_some(),
        is(Lqr),
        "--q and --r",
        "lqr",
    )?;
    let is_told = args.natural.is_some() || args.damping.is_some();
    let options = "--natural and --damping";
    belongs(is_told, is(ComputedTorque), options, "computed-torque")?;
    Ok(match args.controller {
        Paper => Controller::StateFeedback(Gains::Paper),
        Lqr => match Setup::best().controller {
            Controller::StateFeedback(Gains::Design { q, r }) => {
                Controller::StateFeedback(Gains::Design {
                    q: args.q.unwrap_or(q),
                    r: args.r.unwrap_or(r),
                })
            }
            other => other,
        },
        ComputedTorque => Controller::ComputedTorque {
            natural_rad_s: args.natural.unwrap_or([NATURAL_RAD_S; JOINTS]),
            damping: args.damping.unwrap_or([1.0; JOINTS]),
        },
    })
}

fn estimator(args: &BenchArgs) -> Result<Config<f32>, String> {
    use EstimatorName::{Difference, Filtered, Kalman, Luenberger};
    let is = |name| args.estimator == name;
    belongs(args.filter.is_some(), is(Filtered), "--filter", "filtered")?;
    let is_told = args.poles.is_some() || args.prediction;
    belongs(
        is_told,
        is(Luenberger),
        "--poles and --prediction",
        "luenberger",
    )?;
    let kalman = [
        args.angle_noise,
        args.acceleration_noise,
        args.walk,
        args.coulomb,
        args.slide,
    ];
    let options = "--angle-noise, --acceleration-noise, --walk, --coulomb and --slide";
    belongs(
        kalman.iter().any(Option::is_some),
        is(Kalman),
        options,
        "kalman",
    )?;
    Ok(match args.estimator {
        Difference => Config::FiniteDifference { filter_s: 0.0 },
        Filtered => Config::FiniteDifference {
            filter_s: args.filter.unwrap_or(FILTER_S),
        },
        Luenberger => match Config::standing() {
            Config::Luenberger { form, poles_45ms } => Config::Luenberger {
                form: if args.prediction {
                    Form::Prediction
                } else {
                    form
                },
                poles_45ms: args
                    .poles
                    .map_or(poles_45ms, |[a, b, c, d]| [[a, b], [c, d]]),
            },
            other => other,
        },
        Kalman => {
            let standing = Tuning::standing();
            Config::Kalman(Tuning {
                angle_rad: args.angle_noise.unwrap_or(standing.angle_rad),
                acceleration: args.acceleration_noise.unwrap_or(standing.acceleration),
                disturbance: args.walk.unwrap_or(standing.disturbance),
                coulomb_nm: args.coulomb.unwrap_or(standing.coulomb_nm),
                slide_rad_s: args.slide.unwrap_or(standing.slide_rad_s),
            })
        }
    })
}

/// An option that would have no effect is a mistake.
fn belongs(is_told: bool, is_chosen: bool, options: &str, to: &str) -> Result<(), String> {
    if is_told && !is_chosen {
        return Err(format!("{options} go with `{to}`, which is not chosen"));
    }
    Ok(())
}

fn heading(args: &BenchArgs, trial: &Trial) -> String {
    let name = |value: Option<clap::builder::PossibleValue>| {
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    };
    format!(
        "armbridge bench · simulated · {} · {} · period {} µs · {} s",
        name(clap::ValueEnum::to_possible_value(&args.controller)),
        name(clap::ValueEnum::to_possible_value(&args.estimator)),
        trial.script.setup.period_us,
        args.duration,
    )
}

/// Plots and logs of a run.
fn write(folder: &Path, facts: &RunFacts, run: &Run) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", folder.display()))?;
    let mut mcap = McapWriter::create(&folder.join("run.mcap"), facts)?;
    let mut csv = CsvWriter::create(&folder.join("run.csv"))?;
    for (at_us, command) in &run.commands {
        mcap.command(*at_us, command)?;
    }
    for record in &run.records {
        mcap.record(record)?;
        csv.record(record)?;
    }
    mcap.finish()?;
    csv.finish()?;
    plot::draw_all(folder, facts, &run.records)?;
    Ok(())
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
