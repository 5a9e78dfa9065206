//! Output of `armbridge identify fit`: estimates with their checks, or a diagnosis.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::identify::{
    ArmFit, Diagnosis, Forecast, Page, forecast, holdout_forecasts, write_diagnosis,
};
use armbridge_client::stdio;
use armbridge_log::output_file::Existing;
use armbridge_log::text_table;

use super::super::{Error, Outcome};
use super::{FitArgs, paths};

/// Output wanted beside the parameters.
pub(super) struct OutputOptions<'a> {
    /// Logs to validate them on; if empty, the last windows of their own.
    pub(super) held_out: &'a [PathBuf],
    /// Folder of the page.
    pub(super) folder: Option<&'a Path>,
    /// Rule for a page that exists.
    pub(super) existing: Existing,
}

/// A fit's description.
pub(super) struct Description {
    /// Text, ending in a line feed.
    pub(super) text: String,
    /// JSON.
    pub(super) json: serde_json::Value,
}

/// Describes a fit, and writes the page if one is wanted.
pub(super) fn describe(fit: &ArmFit, options: &OutputOptions<'_>) -> Result<Description, Error> {
    let forecasts = forecasts(fit, options.held_out)?;
    let mut json = serde_json::to_value(&fit.report)?;
    json["checks"] = serde_json::to_value(&fit.checks)?;
    json["forecasts"] = serde_json::to_value(&forecasts)?;
    let held_out = held_out(options.held_out);
    let mut text = fit.report.table() + &fit.checks.text();
    text += &as_text(held_out, forecasts.as_deref());
    if let Some(folder) = options.folder {
        let page = Page {
            logs: &fit.logs,
            report: &fit.report,
            fit: &fit.result,
            checks: &fit.checks,
            forecasts: forecasts.as_deref(),
            held_out,
            known: &fit.known,
        };
        create(folder)?;
        text += &page.write(folder, options.existing)?.display().to_string();
        text.push('\n');
    }
    Ok(Description { text, json })
}

/// The diagnosis of logs that do not identify the arm.
pub(super) fn print_diagnosis(error: &Error, args: &FitArgs) -> Outcome {
    if args.json {
        stdio::print_line(serde_json::json!({ "diagnosis": error.to_string() }))?;
    }
    if let (Some(folder), Some(diagnosis)) = (&args.report, error.downcast_ref::<Diagnosis>()) {
        create(folder)?;
        let logs = args.logs.iter().map(|log| log.display().to_string());
        write_diagnosis(
            folder,
            diagnosis,
            &logs.collect::<Vec<_>>(),
            args.force.chosen(),
        )?;
    }
    stdio::note(format_args!("not identified: {error}"));
    Ok(ExitCode::from(1))
}

fn create(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create {}: {error}", folder.display()).into())
}

/// Validation on data excluded from the fit; `None` if that takes too long.
fn forecasts(fit: &ArmFit, held_out: &[PathBuf]) -> Result<Option<Vec<Forecast>>, Error> {
    if held_out.is_empty() {
        return Ok(holdout_forecasts(
            &fit.result,
            &fit.checks,
            &fit.known,
            &fit.prior,
        ));
    }
    let held = fit.held_out(&paths(held_out)?)?;
    Ok(Some(forecast(&fit.result, &held, &fit.known)))
}

fn as_text(held_out: &str, forecasts: Option<&[Forecast]>) -> String {
    let Some(forecasts) = forecasts else {
        return "not validated on held-out windows, which would take long; give another log as \
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
