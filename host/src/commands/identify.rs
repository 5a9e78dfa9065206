//! `armbridge identify`: what an arm is, from its logs.

mod apply;
mod paper;
mod preview;
mod run;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge::identify::{Found, Known, NoStart, Prior, Report, Trace, find, settings, traces};
use armbridge::log::find::find as find_log;
use armbridge::log::recording::Recording;
use armbridge::params::{self, Parameter};
use armbridge::run_folder::DEFAULT_BASE;
use armbridge_shared::link::message::Settings;
use toml::Value;

use self::apply::Apply;
use super::{Error, Outcome};
use crate::cli::{FitArgs, Identify, IdentifyArgs};

pub(crate) fn run(args: &IdentifyArgs) -> Outcome {
    match &args.what {
        Identify::Run(args) => run::run(args),
        Identify::Fit(args) => fit(args),
        Identify::Paper(args) => paper::run(args),
    }
}

fn fit(args: &FitArgs) -> Outcome {
    let logs: Vec<Option<&Path>> = if args.logs.is_empty() {
        vec![None]
    } else {
        args.logs.iter().map(|log| Some(log.as_path())).collect()
    };
    let fit = Fit::of(&logs, args.weighed)?;
    let text = if args.json {
        serde_json::to_string(&fit.report)? + "\n"
    } else {
        fit.report.table()
    };
    write!(std::io::stdout(), "{text}").map_err(|error| format!("cannot print: {error}"))?;
    if let Some(path) = &args.out {
        fit.write_to(path)?;
    }
    if !args.apply {
        return Ok(ExitCode::SUCCESS);
    }
    let applied = Apply {
        link: &args.link,
        is_sure: args.yes,
        is_silent: args.json,
    }
    .to_board(&fit)?;
    Ok(applied.exit_code())
}

/// What logs have told of an arm.
struct Fit {
    /// What the board computed with meanwhile.
    before: Settings,
    found: Found,
    report: Report,
}

impl Fit {
    /// Of these logs; of the newest one where `None` is.
    fn of(logs: &[Option<&Path>], weighed: f64) -> Result<Self, Error> {
        let (before, traces) = load(logs)?;
        let known = Known::of(&before.setup);
        let prior = Prior::of(&before.setup, weighed);
        let found = find(&traces, &known, &prior).map_err(|error| in_words(&error))?;
        let report = Report::new(&found, &prior, known.period_s);
        Ok(Self {
            before,
            found,
            report,
        })
    }

    /// What is to be changed of a board that worked as then.
    fn changes(&self) -> Result<Vec<(&'static Parameter, Value)>, Error> {
        let after = settings(&self.before, &self.found)?;
        Ok(params::changed(&self.before, &after))
    }

    /// The same, with tables as in armbridge.toml.
    fn write_to(&self, path: &Path) -> Result<(), Error> {
        let table = params::to_table(self.changes()?);
        std::fs::write(path, toml::to_string(&table)?)
            .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
    }
}

/// The settings of the first log, and what all of them have of use.
fn load(logs: &[Option<&Path>]) -> Result<(Settings, Vec<Trace>), Error> {
    let mut first: Option<(PathBuf, Settings)> = None;
    let mut all = Vec::new();
    for log in logs {
        let path = find_log(*log, Path::new(DEFAULT_BASE))?;
        let recording = Recording::load(&path)?;
        for damage in &recording.damage {
            eprintln!("{}: {damage}", path.display());
        }
        let settings = recording.settings.ok_or_else(|| {
            let path = path.display();
            format!("{path} does not say what the board computes with; record from the hello on")
        })?;
        let (named, before) = first.get_or_insert_with(|| (path.clone(), settings));
        if before.setup.joints != settings.setup.joints
            || before.setup.arm != settings.setup.arm
            || before.setup.period_us != settings.setup.period_us
        {
            return Err(format!(
                "{} and {} are of boards that believe in different arms; fit them one by one",
                named.display(),
                path.display()
            )
            .into());
        }
        all.extend(traces(&recording.records()));
    }
    match first {
        Some((_, settings)) => Ok((settings, all)),
        None => Err("name a log".into()),
    }
}

fn in_words(error: &NoStart) -> String {
    let NoStart {
        joint,
        stretches,
        gain,
    } = error;
    let joint = joint + 1;
    if *gain == 0.0 {
        format!(
            "joint {joint} slides in {stretches} stretches of 160 ticks only: too short a log; let \
             it move for some ten seconds under its motor, as `armbridge run multisine` does"
        )
    } else {
        format!(
            "joint {joint} does not move as its motor pushes (a gain of {gain:.0} counts/N m): is \
             it the right joint, does its direction hold, was it held by hand?"
        )
    }
}
