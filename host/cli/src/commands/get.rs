//! `armbridge get`: what the board computes with.

use std::io::Write;
use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_client::params;
use armbridge_client::params::exchange::Exchange;
use armbridge_client::params::{Parameter, to_text};
use armbridge_log::table;
use armbridge_shared::link::message::Settings;
use serde_json::{Value, json};

use super::{Outcome, link};
use crate::cli::GetArgs;

pub(crate) fn run(args: &GetArgs) -> Outcome {
    let asked = asked(&args.keys)?;
    let host = link::run_host(
        &args.link,
        &Config::discover()?,
        Exchange::new(|_| Vec::new()),
    )?;
    let Some(settings) = host.exchanged.before else {
        return Err("the board did not say what it computes with; ask again".into());
    };
    // Whoever names one wants to see it.
    let all = args.all || args.keys.iter().any(|key| params::find(key).is_some());
    let shown: Vec<_> = asked
        .into_iter()
        .filter(|parameter| all || parameter.value(&settings).is_some())
        .collect();
    let mut out = std::io::stdout();
    if args.json {
        let rows: Vec<Value> = shown.iter().map(|p| as_json(p, &settings)).collect();
        writeln!(out, "{}", Value::from(rows))?;
    } else {
        let heads = ["key", "value", "unit", "what"].map(str::to_owned).to_vec();
        let rows = shown.iter().map(|parameter| row(parameter, &settings));
        let rows: Vec<Vec<String>> = std::iter::once(heads).chain(rows).collect();
        write!(out, "{}", table::columns(&rows))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Parameters by their names, or those of groups.
fn asked(keys: &[String]) -> Result<Vec<&'static Parameter>, params::ParameterError> {
    let of_key = |key: &String| {
        let is_it = |parameter: &&Parameter| parameter.key == key || parameter.group() == key;
        let found: Vec<_> = params::all().iter().filter(is_it).collect();
        if found.is_empty() {
            Err(params::unknown(key))
        } else {
            Ok(found)
        }
    };
    if keys.is_empty() {
        return Ok(params::all().iter().collect());
    }
    let found: Result<Vec<_>, _> = keys.iter().map(of_key).collect();
    Ok(found?.concat())
}

fn row(parameter: &Parameter, settings: &Settings) -> Vec<String> {
    let value = parameter.value(settings);
    let about = match (&value, parameter.goes_with()) {
        (None, Some((kind, with))) => {
            format!(
                "{} Only with {} {}.",
                parameter.about,
                kind.key,
                with.join(" or ")
            )
        }
        (Some(_), _) | (None, None) => parameter.about.to_owned(),
    };
    let value = value.as_ref().map_or_else(|| "-".to_owned(), to_text);
    vec![
        parameter.key.to_owned(),
        value,
        parameter.unit.to_owned(),
        about,
    ]
}

fn as_json(parameter: &Parameter, settings: &Settings) -> Value {
    json!({
        "key": parameter.key,
        "value": parameter.value(settings),
        "unit": parameter.unit,
        "what": parameter.about,
        "takes": parameter.takes.to_string(),
    })
}
