//! `armbridge identify`: an arm's parameters, from its logs.

mod apply;
mod output;
mod paper;
mod preview;
mod run;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::identify::{
    Checks, Diagnosis, FitResult, KnownParameters, PAGE_NAME, Prior, Report, Tally, Trace,
    identified_settings, identify, traces,
};
use armbridge_client::params::Parameter;
use armbridge_client::{params, stdio};
use armbridge_link::message::Settings;
use armbridge_log::inspect::Log;
use armbridge_log::output_file;
use armbridge_log::output_file::Existing;
use clap::{Args, Subcommand};
use toml::Value;

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
  armbridge identify paper";

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
    }
}

fn fit(args: &FitArgs) -> Outcome {
    // A fit takes long: a file that is in the way is reported first.
    let report = args.report.as_ref().map(|folder| folder.join(PAGE_NAME));
    for path in args.out.iter().chain(&report) {
        args.force.check(path)?;
    }
    let fit = Fit::from_logs(&paths(&args.logs), args.weighed)?;
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
        fit.write_to(path, args.force.chosen())?;
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

/// An arm fitted to logs.
struct Fit {
    /// Settings of the board that recorded them.
    before: Settings,
    known: KnownParameters,
    prior: Prior,
    result: FitResult,
    report: Report,
    checks: Checks,
    /// Each log's path, name and link.
    logs: Vec<String>,
}

impl Fit {
    /// Fits these logs; `None` is the newest one.
    fn from_logs(logs: &[Option<&Path>], weighed: f64) -> Result<Self, Error> {
        let Loaded {
            settings: before,
            traces,
            tally,
            logs,
        } = load(logs)?;
        let known = KnownParameters::from_setup(&before.setup);
        let prior = Prior::from_setup(&before.setup, weighed);
        let result = identify(&traces, &tally, &known, &prior)?;
        Ok(Self {
            report: Report::new(&result, &prior, known.period_s),
            checks: Checks::new(&result, &traces, &known, &prior),
            before,
            known,
            prior,
            result,
            logs,
        })
    }

    /// All parameters of the arm: the identified ones, and the known ones, such as its lengths
    /// and mounting.
    fn arm(&self) -> Result<Vec<(&'static Parameter, Value)>, Error> {
        let after = identified_settings(&self.before, &self.result)?;
        let is_of_arm = |parameter: &Parameter| {
            ["arm", "joint1", "joint2"].contains(&parameter.group())
                || parameter.key == "setup.friction_nm"
        };
        let all = params::pairs(&after).into_iter();
        Ok(all.filter(|(parameter, _)| is_of_arm(parameter)).collect())
    }

    /// Writes them to a file, with tables as in armbridge.toml.
    fn write_to(&self, path: &Path, existing: Existing) -> Result<(), Error> {
        let table = params::to_table(self.arm()?);
        output_file::write(path, toml::to_string(&table)?.as_bytes(), existing)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        Ok(())
    }
}

/// The named logs; the newest one if none is.
fn paths(logs: &[PathBuf]) -> Vec<Option<&Path>> {
    match logs {
        [] => vec![None],
        logs => logs.iter().map(|log| Some(log.as_path())).collect(),
    }
}

/// Data of logs that a fit uses.
struct Loaded {
    /// Settings of the first log.
    settings: Settings,
    /// Traces of all logs.
    traces: Vec<Trace>,
    tally: Tally,
    /// Each log's path, name and link.
    logs: Vec<String>,
}

fn load(logs: &[Option<&Path>]) -> Result<Loaded, Error> {
    let mut first: Option<(PathBuf, Settings)> = None;
    let (mut all, mut tally, mut names) = (Vec::new(), Tally::default(), Vec::new());
    for (index, log) in logs.iter().enumerate() {
        let path = log::find(*log)?;
        let Log { head, records, .. } = Log::load(&path)?;
        for damage in &head.damage {
            stdio::note(format_args!("{}: {damage}", path.display()));
        }
        if records.is_empty() {
            return Err(Diagnosis::Empty.into());
        }
        let settings = head.settings.ok_or_else(|| {
            let path = path.display();
            format!("{path} has no settings of the board; record from the hello on")
        })?;
        let (named, before) = first.get_or_insert_with(|| (path.clone(), settings));
        check_same_model(before, &settings)
            .map_err(|error| format!("{} and {}: {error}", named.display(), path.display()))?;
        let facts = &head.facts;
        names.push(format!(
            "{} · {} · {}",
            path.display(),
            facts.name,
            facts.describe()
        ));
        tally.add(&records, &settings.limits);
        let traces = traces(&records).into_iter();
        all.extend(traces.map(|trace| Trace {
            log: index,
            ..trace
        }));
    }
    match first {
        Some((_, settings)) => Ok(Loaded {
            settings,
            traces: all,
            tally,
            logs: names,
        }),
        None => Err("name a log".into()),
    }
}

/// Checks that two boards have the same model of the arm and the same period.
fn check_same_model(one: &Settings, other: &Settings) -> Result<(), Error> {
    let (one, other) = (&one.setup, &other.setup);
    let what = if one.period_us != other.period_us {
        format!("periods, {} and {} µs", one.period_us, other.period_us)
    } else if one.joints != other.joints {
        "calibrations or actuators of the joints".into()
    } else if one.arm != other.arm {
        "models of the arm".into()
    } else {
        return Ok(());
    };
    Err(format!("the boards of these logs have different {what}; fit them one by one").into())
}
