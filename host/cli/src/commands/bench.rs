//! `armbridge bench`: trials of any set-up on any virtual arm, for many seeds.

mod setup;

use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;

use armbridge_analysis::monte_carlo;
use armbridge_analysis::monte_carlo::{Maneuver, Outcome as Trialled, Run, Trial};
use armbridge_analysis::plot;
use armbridge_analysis::progress::Progress;
use armbridge_client::params;
use armbridge_client::params::JointPoles;
use armbridge_client::{ctrl_c, stdio};
use armbridge_log::CsvWriter;
use armbridge_log::output_file::OutputFile;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Row;
use armbridge_log::run_info::RunFacts;
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Pwm;
use armbridge_shared::link::message::Setup;
use armbridge_sim::plant::{PlantConfig, PlantFile, Push};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::{Error, Outcome};
use crate::args::ForceArgs;
use crate::args::suggestions::plants;
use crate::args::values::{
    Seeds, angles, duration, not_negative, numbers, period, positive, seeds, weights,
};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge bench
  armbridge bench --estimator luenberger --friction 0,0 --seeds 1..20
  armbridge bench --controller computed-torque --natural 20,20 --reference sine:0.3,0.3,1
  armbridge bench --plant dead-zone --disturb 1,0.2,3,0.05 --loss 0.2

Unspecified options use the recommended settings: the LQR, the Kalman filter, and
0.04 N m against friction. Results are of the true arm's worse joint. Ctrl-C ends the
bench after the trials that have begun; the finished ones are printed, and the exit code
is 130.";

/// Trials on the bench.
#[derive(Args, Debug)]
pub(crate) struct BenchArgs {
    /// Use the recommended settings, which are the default.
    #[arg(long, conflicts_with_all = ["controller", "estimator", "friction"])]
    pub(crate) best: bool,
    #[command(flatten)]
    pub(crate) control: ControlArgs,
    #[command(flatten)]
    pub(crate) estimate: EstimateArgs,
    /// Feed-forward torque against dry friction, in N m [default: 0.04,0.04].
    #[arg(long, value_name = "NM,NM", value_parser = weights::<2>)]
    pub(crate) friction: Option<[f32; JOINTS]>,
    /// Tick period in µs.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = period)]
    pub(crate) period_us: u32,
    /// Virtual arm: the name of one that ships (`armbridge plants`), or a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    pub(crate) plant: Option<String>,
    /// Reference: upright, hold:Q1,Q2, step:Q1,Q2, min-jerk:Q1,Q2[,S], sine:A1,A2,HZ or
    /// chirp:A1,A2,HZ,HZ; in rad. Motions begin upright, after 2 s.
    #[arg(long, value_name = "WHAT", default_value = "upright")]
    pub(crate) reference: Maneuver,
    /// Joint angles in rad at which the arm is held until torque comes on
    /// [default: 0.49,-0.3, or as the plant file sets them].
    #[arg(long, value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) initial: Option<[f64; JOINTS]>,
    /// Push joint 1 or 2 with this torque, from this time on, for this duration; may be
    /// repeated.
    #[arg(long, value_name = "JOINT,NM,START_S,DURATION_S", value_parser = push,
          allow_hyphen_values = true)]
    pub(crate) disturb: Vec<Push>,
    /// Fraction of the servos' replies that is damaged at random, 0 to 1.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub(crate) loss: f64,
    /// Random seeds: 1..20, or 1,2,3.
    #[arg(long, default_value = "1..5", value_parser = seeds)]
    pub(crate) seeds: Seeds,
    /// Simulated time in s from the first setpoint on.
    #[arg(long, value_name = "S", default_value_t = 8.0, value_parser = duration)]
    pub(crate) duration: f64,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the first seed's plots and log to this folder.
    #[arg(long, value_name = "DIR")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// From state to torque.
#[derive(Args, Debug)]
pub(crate) struct ControlArgs {
    /// Control law.
    #[arg(long, value_enum, default_value_t = ControllerName::Lqr)]
    pub(crate) controller: ControllerName,
    /// Diagonal of the LQR's Q: both angles, both speeds.
    #[arg(long, value_name = "A,B,C,D", value_parser = weights::<4>)]
    pub(crate) q: Option<[f32; 4]>,
    /// Diagonal of the LQR's R: both torques.
    #[arg(long, value_name = "A,B", value_parser = weights::<2>)]
    pub(crate) r: Option<[f32; 2]>,
    /// Natural frequencies of the computed torque's errors, in rad/s.
    #[arg(long, value_name = "W1,W2", value_parser = weights::<2>)]
    pub(crate) natural: Option<[f32; JOINTS]>,
    /// Damping ratios of the computed torque's errors.
    #[arg(long, value_name = "Z1,Z2", value_parser = weights::<2>)]
    pub(crate) damping: Option<[f32; JOINTS]>,
}

/// From samples to state.
#[derive(Args, Debug)]
pub(crate) struct EstimateArgs {
    /// State estimator.
    #[arg(long, value_enum, default_value_t = EstimatorName::Kalman)]
    pub(crate) estimator: EstimatorName,
    /// Time constant of the filtered difference in s [default: 0.02].
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) filter: Option<f32>,
    /// Poles of the Luenberger observer at 45 ms, two for each joint: real ones, or a pair
    /// as 0.6±0.2i.
    #[arg(long, value_name = "P,P,P,P", value_parser = poles)]
    pub(crate) poles: Option<JointPoles>,
    /// Let the observer see each sample one period late, as the paper prints it.
    #[arg(long)]
    pub(crate) prediction: bool,
    /// Angle noise of the Kalman filter, in rad.
    #[arg(long, value_name = "RAD", value_parser = positive)]
    pub(crate) angle_noise: Option<f32>,
    /// Acceleration noise of the Kalman filter, in rad/s² per root Hz.
    #[arg(long, value_name = "X", value_parser = positive)]
    pub(crate) acceleration_noise: Option<f32>,
    /// Random walk of the Kalman filter's disturbance, in N m per root s.
    #[arg(long, value_name = "X", value_parser = not_negative)]
    pub(crate) walk: Option<f32>,
    /// Coulomb friction in the Kalman filter's model, in N m.
    #[arg(long, value_name = "NM", value_parser = not_negative)]
    pub(crate) coulomb: Option<f32>,
    /// Speed above which that friction is fully developed, in rad/s.
    #[arg(long, value_name = "RAD/S", value_parser = positive)]
    pub(crate) slide: Option<f32>,
}

/// Control laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ControllerName {
    /// The gain that the paper prints, meant for 45 ms.
    Paper,
    /// LQR, designed for the period.
    Lqr,
    /// Feedback linearisation.
    ComputedTorque,
}

/// Estimators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EstimatorName {
    /// Plain backward difference.
    Difference,
    /// Backward difference through a low pass.
    Filtered,
    /// The paper's observer (11).
    Luenberger,
    /// Kalman filter with disturbance torques.
    Kalman,
}

fn poles(text: &str) -> Result<JointPoles, String> {
    params::joint_poles(text).ok_or_else(|| {
        "expected two poles for each joint: numbers from 0 and below 1, or a pair as 0.6±0.2i \
         with a magnitude below 1"
            .into()
    })
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("expected a fraction from 0 to 1".into()),
    }
}

fn push(text: &str) -> Result<Push, String> {
    /// Torque in N m beyond which no hand pushes, and the longest run in s.
    const MOST: [f64; 2] = [10.0, 3_600.0];

    let push = || {
        let (joint, rest) = text.split_once(',')?;
        let [torque_nm, start_s, duration_s] = numbers(rest)?;
        let joint = ["1", "2"].into_iter().position(|j| j == joint.trim())?;
        let is_time = |s: f64| (0.0..=MOST[1]).contains(&s);
        let is_push = f64::abs(torque_nm) <= MOST[0] && is_time(start_s) && is_time(duration_s);
        let nanoseconds = |s: f64| (s * 1e9) as u64;
        is_push.then(|| Push {
            joint,
            torque_nm,
            start_ns: nanoseconds(start_s),
            duration_ns: nanoseconds(duration_s),
        })
    };
    push()
        .ok_or_else(|| "expected joint 1 or 2, N m, and two times in s, as 1,0.2,3,0.05".to_owned())
}

/// Default initial angles in rad.
const INITIAL_RAD: [f64; JOINTS] = [0.49, -0.3];

pub(crate) fn run(args: &BenchArgs) -> Outcome {
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

fn print(args: &BenchArgs, trial: &Trial, outcomes: &[Trialled]) -> Result<(), Error> {
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

fn trial(args: &BenchArgs) -> Result<Trial, Error> {
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
fn recorder(args: &BenchArgs, trial: &Trial) -> Result<Option<Recorder>, Error> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_what_is_meant() {
        assert_eq!(seeds("2..4"), Ok(Seeds(vec![2, 3, 4])));
        assert_eq!(seeds("7,1"), Ok(Seeds(vec![7, 1])));
        for wrong in ["", "4..2", "1..999999", "a", "1,", "-1"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
        let pushed = push("2,-0.2,3,0.05").unwrap();
        assert_eq!((pushed.joint, pushed.torque_nm), (1, -0.2));
        assert_eq!(
            (pushed.start_ns, pushed.duration_ns),
            (3_000_000_000, 50_000_000)
        );
        for wrong in ["0,1,1,1", "1.5,1,1,1", "1,nan,1,1", "1,1,-1,1", "1,1,1"] {
            assert!(push(wrong).is_err(), "{wrong}");
        }
    }
}
