//! `armbridge params`: the board's parameters, shown or changed.

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge::config;
use armbridge::config::Config;
use armbridge_client::params::settings_exchange::Exchange;
use armbridge_client::params::{Parameter, to_text};
use armbridge_client::toml_file::Document;
use armbridge_client::transport::Intent;
use armbridge_client::{params, stdio};
use armbridge_link::message::Settings;
use armbridge_log::text_table;
use clap::Args;
use serde_json::{Value, json};
use toml::Value as TomlValue;

use super::params_exchange::{ExchangeOptions, apply};
use super::{Error, Outcome, link};
use crate::args::LinkArgs;
use crate::args::suggestions::keys;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge params
  armbridge params limits controller.q --link serial:
  armbridge params limits.hold_ms=80 controller.q=30,30,0.3,0.3 --link serial:
  armbridge params controller.kind=computed-torque controller.damping=1,1
  armbridge params --from gains.toml --save

A group such as limits stands for all of its parameters, and those named are
explained. The board accepts all changes of a group or none: the limits, only
while it is idle, and the set-up, without a step in the torque. Exit code 1 if
it refuses.";

/// Begin of a line that explains.
const INDENT: &str = "    ";
/// Last line of the table of all.
const EXPLAINED: &str = "\nA group or a key as an argument is explained: armbridge params limits\n";

/// Parameters to show or change.
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
#[derive(Args, Debug)]
pub(crate) struct ParamsArgs {
    /// Parameters or groups to show, or parameters to change with their values, lists
    /// separated by commas [default: show all].
    #[arg(value_name = "KEY|KEY=VALUE", value_parser = keys())]
    pub(crate) keys: Vec<String>,
    /// Take changes from a file with tables as in armbridge.toml, such as `design --write`
    /// writes; the command line overrides it.
    #[arg(long, value_name = "FILE")]
    pub(crate) from: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Save all the board's settings, so that they survive power-off.
    #[arg(long)]
    pub(crate) save: bool,
    /// Show the changes without making them.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Also show the parameters of controllers and estimators not in use.
    #[arg(long)]
    pub(crate) all: bool,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &ParamsArgs) -> Outcome {
    let (pairs, keys): (Vec<_>, Vec<_>) = args.keys.iter().partition(|key| key.contains('='));
    let is_change = !pairs.is_empty() || args.from.is_some() || args.save;
    if !is_change {
        return show(args);
    }
    if let Some(key) = keys.first() {
        return Err(format!(
            "`{key}` has no value: parameters are either shown or changed, as {key}=VALUE"
        )
        .into());
    }
    let pairs: Result<Vec<_>, _> = pairs.into_iter().map(|pair| params::pair(pair)).collect();
    change(args, &pairs?)
}

fn change(args: &ParamsArgs, pairs: &[(String, TomlValue)]) -> Outcome {
    let file = args.from.as_deref().map(Document::read).transpose()?;
    let options = ExchangeOptions {
        link: &args.link,
        save: args.save,
        dry_run: args.dry_run,
        json: args.json,
    };
    apply(&options, |before: &Settings| {
        wanted(before, file.as_ref(), pairs)
    })
}

/// The board's settings, changed by the file, then by the command line.
fn wanted(
    before: &Settings,
    file: Option<&Document>,
    pairs: &[(String, TomlValue)],
) -> Result<Settings, Error> {
    let mut after = *before;
    if let Some(file) = file {
        // An armbridge.toml has the host's own keys, too.
        let is_own = |key: &str| config::KEYS.iter().any(|own| own.key == key);
        let entries = file.entries().filter(|(key, _)| !is_own(key));
        let entries = entries.map(|(key, entry)| (key, &entry.value));
        params::apply(&mut after, entries)
            .map_err(|error| file.wrong_key(error.key(), error.to_string()))?;
    }
    let pairs = pairs.iter().map(|(key, value)| (key.as_str(), value));
    Ok(params::replaced(&after, pairs)?)
}

fn show(args: &ParamsArgs) -> Outcome {
    let requested = requested(&args.keys)?;
    let host = link::run_host(
        &args.link,
        &Config::discover()?,
        Intent::CommandOrObserve,
        Exchange::new(|_| Vec::new()),
    )?;
    let Some(settings) = host.exchanged.before else {
        return Err("the board did not report its settings; try again".into());
    };
    // A parameter that is named is shown, of whatever kind.
    let all = args.all || args.keys.iter().any(|key| params::find(key).is_some());
    let shown: Vec<_> = requested
        .into_iter()
        .filter(|parameter| all || parameter.value(&settings).is_some())
        .collect();
    if args.json {
        let rows: Vec<Value> = shown.iter().map(|p| as_json(p, &settings)).collect();
        stdio::print_line(Value::from(rows))?;
    } else {
        stdio::print(as_text(&shown, &settings, !args.keys.is_empty()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A table of parameters; explained if they are few.
fn as_text(shown: &[&Parameter], settings: &Settings, is_explained: bool) -> String {
    let keys = shown.iter().map(|parameter| parameter.key.len());
    let width = keys.max().unwrap_or_default();
    let mut text = format!("{:<width$}  value\n", "key");
    for parameter in shown {
        let value = value_text(parameter, settings);
        let indent = " ".repeat(width + 2);
        let row = format!("{:<width$}  {value}", parameter.key);
        text.push_str(&text_table::fold(&row, &indent));
        if is_explained {
            let about = format!("{INDENT}{}", about(parameter, settings));
            text.push_str(&text_table::fold(&about, INDENT));
        }
    }
    if !is_explained {
        text.push_str(EXPLAINED);
    }
    text
}

/// Parameters by their names, or those of groups.
fn requested(keys: &[String]) -> Result<Vec<&'static Parameter>, Error> {
    let of_key = |key: &String| {
        let is_it = |parameter: &&Parameter| parameter.key == key || parameter.group() == key;
        let found: Vec<_> = params::all().iter().filter(is_it).collect();
        if found.is_empty() {
            Err(unknown(key))
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

/// Error of a name that is neither a parameter nor a group.
fn unknown(key: &str) -> Error {
    let mut groups: Vec<_> = params::all().iter().map(Parameter::group).collect();
    groups.dedup();
    match params::nearest(key, groups.iter().copied()) {
        _ if key.contains('.') => params::unknown(key).into(),
        Some(group) => format!("there is no parameter or group `{key}`; is it `{group}`?").into(),
        None => format!(
            "there is no parameter or group `{key}`; the groups are {}",
            groups.join(", ")
        )
        .into(),
    }
}

/// Meaning of a parameter; of one that is not in use, what it belongs to as well.
fn about(parameter: &Parameter, settings: &Settings) -> String {
    match (parameter.value(settings), parameter.goes_with()) {
        (None, Some((kind, with))) => {
            format!(
                "{} Only with {} {}.",
                parameter.about,
                kind.key,
                with.join(" or ")
            )
        }
        (Some(_), _) | (None, None) => parameter.about.to_owned(),
    }
}

/// The value with its unit; `-`, and the unit in brackets, for one that is not in use.
fn value_text(parameter: &Parameter, settings: &Settings) -> String {
    match (parameter.value(settings), parameter.unit) {
        (Some(value), unit) => format!("{} {unit}", to_text(&value)).trim_end().to_owned(),
        (None, "") => "-".to_owned(),
        (None, unit) => format!("- ({unit})"),
    }
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
