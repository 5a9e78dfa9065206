//! What `armbridge identify fit` prints and draws: numbers with what the fit says of itself,
//! or why there are none.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::identify::{
    Diagnosis, Forecast, Page, forecast, no_numbers, without_the_last,
};
use armbridge_log::text_table;

use super::super::{Error, Outcome};
use super::FitArgs;
use super::{Fit, is_same, load, paths};

/// What is wanted beside the numbers.
pub(super) struct Wish<'a> {
    /// Logs to try them on; the last part of their own without.
    pub(super) held_out: &'a [PathBuf],
    /// Where to put the page.
    pub(super) folder: Option<&'a Path>,
}

/// What there is to say of a fit.
pub(super) struct Told {
    /// For a person, ending in a line feed.
    pub(super) text: String,
    /// For a program.
    pub(super) json: serde_json::Value,
}

/// Puts it in words, and draws the page if that is wanted.
pub(super) fn describe(fit: &Fit, wish: &Wish<'_>) -> Result<Told, Error> {
    let forecasts = forecasts(fit, wish.held_out)?;
    let mut json = serde_json::to_value(&fit.report)?;
    json["checks"] = serde_json::to_value(&fit.checks)?;
    json["forecasts"] = serde_json::to_value(&forecasts)?;
    let held_out = held_out(wish.held_out);
    let mut text = fit.report.table() + &fit.checks.text();
    text += &as_text(held_out, forecasts.as_deref());
    if let Some(folder) = wish.folder {
        let page = Page {
            logs: &fit.logs,
            report: &fit.report,
            found: &fit.found,
            checks: &fit.checks,
            forecasts: forecasts.as_deref(),
            held_out,
            known: &fit.known,
        };
        make(folder)?;
        text += &page.write(folder)?.display().to_string();
        text.push('\n');
    }
    Ok(Told { text, json })
}

/// What is wrong with the logs, in place of numbers.
pub(super) fn without_numbers(error: &Error, args: &FitArgs) -> Outcome {
    if args.json {
        println!("{}", serde_json::json!({ "diagnosis": error.to_string() }));
    }
    if let (Some(folder), Some(diagnosis)) = (&args.report, error.downcast_ref::<Diagnosis>()) {
        make(folder)?;
        let logs = args.logs.iter().map(|log| log.display().to_string());
        no_numbers(folder, diagnosis, &logs.collect::<Vec<_>>())?;
    }
    eprintln!("no numbers: {error}");
    Ok(ExitCode::from(1))
}

fn make(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make {}: {error}", folder.display()).into())
}

/// How well the numbers tell what they were not found in; none if that takes too long.
fn forecasts(fit: &Fit, held_out: &[PathBuf]) -> Result<Option<Vec<Forecast>>, Error> {
    if held_out.is_empty() {
        return Ok(without_the_last(
            &fit.found,
            &fit.checks,
            &fit.known,
            &fit.prior,
        ));
    }
    let held = load(&paths(held_out))?;
    is_same(&fit.before, &held.settings)?;
    Ok(Some(forecast(&fit.found, &held.traces, &fit.known)))
}

fn as_text(held_out: &str, forecasts: Option<&[Forecast]>) -> String {
    let Some(forecasts) = forecasts else {
        return "not tried on windows held out, which would take a while; give another log as \
                --held-out\n"
            .into();
    };
    let mut rows = vec![Forecast::HEADS.map(str::to_owned).to_vec()];
    rows.extend(forecasts.iter().map(|forecast| forecast.cells().to_vec()));
    format!(
        "{held_out}; errors in counts:\n{}",
        text_table::columns(&rows)
    )
}

fn held_out(logs: &[PathBuf]) -> &'static str {
    if logs.is_empty() {
        "the last fifth of the windows, by a fit without it"
    } else {
        "logs held out"
    }
}
