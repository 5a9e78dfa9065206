//! `armbridge config`: the configuration in force, and every key there is.

use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use armbridge::config::{Config, FILE_NAME, InForce, explain};
use armbridge_client::params::to_text;
use armbridge_client::stdio::Stdout;
use armbridge_log::text_table;
use clap::Args;
use serde_json::{Value, json};

use super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge config
  armbridge config --init
  armbridge config --explain | less

armbridge.toml is searched for in the working directory and its parents. Options
of a command override the environment (ARMBRIDGE_LINK, ARMBRIDGE_OUT), which
overrides the file, which overrides the defaults.";

/// The configuration in force.
#[derive(Args, Debug)]
pub(crate) struct ConfigArgs {
    /// Print every key with meaning, unit, default and range, as an armbridge.toml whose
    /// lines are all comments.
    #[arg(long, conflicts_with_all = ["init", "json"])]
    pub(crate) explain: bool,
    /// Write the same to armbridge.toml in the working directory.
    #[arg(long, conflicts_with = "json")]
    pub(crate) init: bool,
    /// Print one JSON array instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &ConfigArgs) -> Outcome {
    let mut out = Stdout;
    if args.explain {
        write!(out, "{}", explain())?;
        return Ok(ExitCode::SUCCESS);
    }
    if args.init {
        return init();
    }
    let config = Config::discover()?;
    let in_force = config.in_force();
    if args.json {
        let rows: Vec<Value> = in_force.iter().map(as_json).collect();
        writeln!(out, "{}", Value::from(rows))?;
        return Ok(ExitCode::SUCCESS);
    }
    let heads = ["key", "value", "unit", "from"].map(str::to_owned).to_vec();
    let rows = in_force.iter().map(|own| {
        vec![
            own.key.to_owned(),
            to_text(&own.value),
            own.unit.to_owned(),
            own.source.to_string(),
        ]
    });
    let rows: Vec<Vec<String>> = std::iter::once(heads).chain(rows).collect();
    write!(out, "{}", text_table::columns(&rows))?;
    let remark = match config.file() {
        Some(file) if config.has_settings() => format!(
            "Runs whose control is the board's own take setup.*, controller.* and estimator.*\n\
             from here, other runs with `--control board`. Limits, model and calibration are\n\
             always the board's. `design` counts with all of it, and\n\
             `armbridge params --from {}` sends a board all of it.",
            file.display()
        ),
        Some(_) => "The file sets nothing on the board, which keeps its own settings.".to_owned(),
        None => "No armbridge.toml here or above: `armbridge config --init` writes one.".to_owned(),
    };
    writeln!(out, "\n{remark}")?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the file, unless there is one.
fn init() -> Outcome {
    let new = std::fs::File::create_new(FILE_NAME);
    let written = new.and_then(|mut file| file.write_all(explain().as_bytes()));
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            format!("there is an {FILE_NAME} here already: edit it, or put it elsewhere first")
        }
        _ => format!("cannot write {FILE_NAME}: {error}"),
    })?;
    writeln!(
        Stdout,
        "written: {FILE_NAME}; take the # off what you want to change"
    )?;
    Ok(ExitCode::SUCCESS)
}

fn as_json(own: &InForce) -> Value {
    json!({
        "key": own.key,
        "value": own.value,
        "unit": own.unit,
        "what": own.about,
        "from": own.source.to_string(),
    })
}
