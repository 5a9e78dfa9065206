//! What `armbridge identify fit` prints and draws: numbers with what the fit says of itself,
//! or why there are none.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use armbridge::identify::{Diagnosis, Forecast, Page, forecast, no_numbers, without_the_last};
use armbridge::table;

use super::super::{Error, Outcome};
use super::{Fit, is_same, load, paths};
use crate::cli::FitArgs;

/// Prints the numbers, and draws the page if that is wanted.
pub(super) fn tell(fit: &Fit, args: &FitArgs) -> Result<(), Error> {
    let forecasts = forecasts(fit, args)?;
    let text = if args.json {
        let mut json = serde_json::to_value(&fit.report)?;
        json["checks"] = serde_json::to_value(&fit.checks)?;
        json["forecasts"] = serde_json::to_value(&forecasts)?;
        format!("{json}\n")
    } else {
        fit.report.table() + &fit.checks.text() + &told(args, forecasts.as_deref())
    };
    write!(std::io::stdout(), "{text}").map_err(|error| format!("cannot print: {error}"))?;
    let Some(folder) = &args.report else {
        return Ok(());
    };
    let page = Page {
        logs: &fit.logs,
        report: &fit.report,
        found: &fit.found,
        checks: &fit.checks,
        forecasts: forecasts.as_deref(),
        held_out: held_out(args),
        known: &fit.known,
    };
    make(folder)?;
    let path = page.write(folder)?;
    if !args.json {
        println!("{}", path.display());
    }
    Ok(())
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
fn forecasts(fit: &Fit, args: &FitArgs) -> Result<Option<Vec<Forecast>>, Error> {
    if args.held_out.is_empty() {
        return Ok(without_the_last(
            &fit.found,
            &fit.checks,
            &fit.known,
            &fit.prior,
        ));
    }
    let held = load(&paths(&args.held_out))?;
    is_same(&fit.before, &held.settings)?;
    Ok(Some(forecast(&fit.found, &held.traces, &fit.known)))
}

fn told(args: &FitArgs, forecasts: Option<&[Forecast]>) -> String {
    let Some(forecasts) = forecasts else {
        return "not tried on windows held out, which would take a while; give another log as \
                --held-out\n"
            .into();
    };
    let mut rows = vec![Forecast::HEADS.map(str::to_owned).to_vec()];
    rows.extend(forecasts.iter().map(|forecast| forecast.cells().to_vec()));
    let head = held_out(args);
    format!("{head}; errors in counts:\n{}", table::columns(&rows))
}

fn held_out(args: &FitArgs) -> &'static str {
    if args.held_out.is_empty() {
        "the last fifth of the windows, by a fit without it"
    } else {
        "logs held out"
    }
}
