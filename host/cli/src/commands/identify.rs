//! `armbridge identify`: an arm's parameters, from its logs.

mod apply;
mod output;
mod paper;
mod pendulum;
mod preview;
mod run;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::identify::{ArmFit, ArmFitError, Diagnosis, FitData, PAGE_NAME};
use armbridge_client::{params, stdio};
use armbridge_log::output_file;
use armbridge_log::output_file::Existing;
use clap::{Args, Subcommand};

use self::apply::Apply;
use self::output::OutputOptions;
use super::{Error, Outcome, log};
use crate::args::{ForceArgs, LinkArgs};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge identify run --link serial:
  armbridge run multisine && armbridge identify fit
  armbridge identify fit runs/*-multisine runs/*-staircase runs/*-stiction
  armbridge identify fit run.mcap --out arm.toml
  armbridge params --from arm.toml --save
  armbridge identify paper
  armbridge identify pendulum raw/*.json";

/// An arm's parameters, from its logs.
#[derive(Args, Debug)]
pub(crate) struct IdentifyArgs {
    #[command(subcommand)]
    pub(crate) what: Identify,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Identify {
    /// Move the arm by a plan, then fit its parameters to the log.
    #[command(after_help = run::EXAMPLES)]
    Run(run::IdentifyRunArgs),
    /// Fit the arm's parameters to these logs.
    #[command(after_help = FIT_EXAMPLES)]
    Fit(FitArgs),
    /// Repeat the paper's identification, and explain its two friction values.
    #[command(after_help = paper::EXAMPLES)]
    Paper(paper::PaperArgs),
    /// Fit one servo on a pendulum to public recordings of a real one.
    #[command(after_help = pendulum::EXAMPLES)]
    Pendulum(pendulum::PendulumArgs),
}

pub(crate) const FIT_EXAMPLES: &str = "\
Examples:
  armbridge identify fit
  armbridge identify fit runs/*-multisine runs/*-staircase --out arm.toml
  armbridge identify fit runs/*-multisine --held-out runs/*-sweep --report page
  armbridge identify fit run.mcap --weighed 0.05 --json

Only ticks in which the motors are driven count, and a joint is informative only
while it slides. Motion determines torques up to a common factor, which the
arm's weight fixes: arm.m1_kg, arm.m2_kg and the lengths in the log. Exit code
1, with a diagnosis and no estimates, if the logs do not identify the arm:
empty, too short, samples lost, clipped, wrong joint, wrong direction, not
driven, external torque, model mismatch.";

#[derive(Args, Debug)]
pub(crate) struct FitArgs {
    /// Logs, or run folders with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Relative standard error of the known weight.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub(crate) weighed: f64,
    /// Validate on this log, excluded from the fit; may be repeated. Without it, the
    /// last fifth of the windows is held out of a second fit, if the logs have at most
    /// 360 000 ticks.
    #[arg(long, value_name = "LOG")]
    pub(crate) held_out: Vec<PathBuf>,
    /// Write the parameters to this file, for `armbridge params --from`.
    #[arg(long, value_name = "TOML")]
    pub(crate) out: Option<PathBuf>,
    /// Send the identified arm to the board, with gains for it, and save it there.
    #[arg(long)]
    pub(crate) apply: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// With --apply, change the board without asking.
    #[arg(long, requires = "apply")]
    pub(crate) yes: bool,
    /// Write report.html, a page with figures, into this folder.
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (1e-4..=1.0).contains(&share) => Ok(share),
        Ok(_) | Err(_) => Err("expected a share from 0.0001 to 1, as 0.01 for 1 %".into()),
    }
}

pub(crate) fn run(args: &IdentifyArgs) -> Outcome {
    match &args.what {
        Identify::Run(args) => run::run(args),
        Identify::Fit(args) => match fit(args) {
            Err(error) if error.is::<Diagnosis>() => output::print_diagnosis(&error, args),
            outcome => outcome,
        },
        Identify::Paper(args) => paper::run(args),
        Identify::Pendulum(args) => pendulum::run(args),
    }
}

fn fit(args: &FitArgs) -> Outcome {
    // A fit takes long: a file that is in the way is reported first.
    let report = args.report.as_ref().map(|folder| folder.join(PAGE_NAME));
    for path in args.out.iter().chain(&report) {
        args.force.check(path)?;
    }
    let fit = fit_logs(&paths(&args.logs)?, args.weighed)?;
    let description = output::describe(
        &fit,
        &OutputOptions {
            held_out: &args.held_out,
            folder: args.report.as_deref(),
            existing: args.force.chosen(),
        },
    )?;
    let text = if args.json {
        description.json.to_string() + "\n"
    } else {
        description.text
    };
    if let Some(path) = &args.out {
        write_to(&fit, path, args.force.chosen())?;
    }
    stdio::print(text)?;
    if !args.apply {
        return Ok(ExitCode::SUCCESS);
    }
    let applied = Apply {
        link: &args.link,
        is_confirmed: args.yes,
        is_silent: args.json,
    }
    .to_board(&fit)?;
    Ok(applied.exit_code())
}

/// Fits an arm to the logs at these paths.
fn fit_logs(logs: &[PathBuf], weighed: f64) -> Result<ArmFit, Error> {
    let data = FitData::load(logs).map_err(|error| match error {
        ArmFitError::Diagnosis(diagnosis) => Error::from(diagnosis),
        error => error.into(),
    })?;
    data.damage.iter().for_each(stdio::note);
    Ok(ArmFit::new(data, weighed)?)
}

/// Writes the parameters of the arm to a file, with tables as in armbridge.toml.
fn write_to(fit: &ArmFit, path: &Path, existing: Existing) -> Result<(), Error> {
    let table = params::to_table(fit.parameters()?);
    output_file::write(path, toml::to_string(&table)?.as_bytes(), existing)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    Ok(())
}

/// Paths of the named logs; that of the newest one if none is.
fn paths(logs: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    match logs {
        [] => Ok(vec![log::find(None)?]),
        logs => logs.iter().map(|path| log::find(Some(path))).collect(),
    }
}
