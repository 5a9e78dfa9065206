//! `armbridge identify`: what an arm is, from its logs.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge::identify::{Known, NoStart, Prior, Report, Trace, find, settings, traces};
use armbridge::log::find::find as find_log;
use armbridge::log::recording::Recording;
use armbridge::params;
use armbridge::run_folder::DEFAULT_BASE;
use armbridge_shared::link::message::Settings;

use super::{Error, Outcome};
use crate::cli::{FitArgs, Identify, IdentifyArgs};

pub(crate) fn run(args: &IdentifyArgs) -> Outcome {
    match &args.what {
        Identify::Fit(args) => fit(args),
    }
}

fn fit(args: &FitArgs) -> Outcome {
    let logs: Vec<Option<&Path>> = if args.logs.is_empty() {
        vec![None]
    } else {
        args.logs.iter().map(|log| Some(log.as_path())).collect()
    };
    let (before, traces) = load(&logs)?;
    let known = Known::of(&before.setup);
    let prior = Prior::of(&before.setup, args.weighed);
    let found = find(&traces, &known, &prior).map_err(|error| in_words(&error))?;
    let report = Report::new(&found, &prior, known.period_s);
    let text = if args.json {
        serde_json::to_string(&report)? + "\n"
    } else {
        report.table()
    };
    write!(std::io::stdout(), "{text}").map_err(|error| format!("cannot print: {error}"))?;
    if let Some(path) = &args.out {
        write_to(path, &before, &settings(&before, &found)?)?;
    }
    Ok(ExitCode::SUCCESS)
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

/// What is to be changed, with tables as in armbridge.toml.
fn write_to(path: &Path, before: &Settings, after: &Settings) -> Result<(), Error> {
    let table = params::to_table(params::changed(before, after));
    std::fs::write(path, toml::to_string(&table)?)
        .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
}
