//! Scenarios that ship: listed and printed.

use std::process::ExitCode;

use armbridge_analysis::scenario::{BUILTINS, Builtin, Overrides, Scenario};
use armbridge_client::stdio;
use armbridge_log::text_table;
use serde::Serialize;

use super::{Error, Outcome};

/// A scenario that ships, as it is listed.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    title: String,
    duration_s: f64,
}

pub(super) fn list(as_json: bool) -> Outcome {
    let listed = BUILTINS.iter().map(|builtin| {
        let scenario = Scenario::load(builtin.name, &Overrides::default())?;
        Ok(Listed {
            name: builtin.name,
            title: scenario.title,
            duration_s: scenario.plan.stop.after_us as f64 * 1e-6,
        })
    });
    let listed: Vec<Listed> = listed.collect::<Result<_, Error>>()?;
    if as_json {
        stdio::print_line(serde_json::to_string(&listed)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows: Vec<Vec<String>> = listed
        .into_iter()
        .map(|row| {
            let duration = format!("{} s", row.duration_s);
            vec![row.name.into(), duration, row.title]
        })
        .collect();
    stdio::print(text_table::columns(&rows))?;
    Ok(ExitCode::SUCCESS)
}

pub(super) fn show(name: &str) -> Outcome {
    let builtin = Builtin::find(name)
        .ok_or_else(|| format!("no scenario `{name}` ships: `armbridge run --list` shows them"))?;
    stdio::print(builtin.text)?;
    Ok(ExitCode::SUCCESS)
}
