//! Every key with its meaning, as a file of comments: what `config --explain` prints and
//! `config --init` writes. Taking the `#` off a line that has a value puts it in force.

use std::fmt::{Result, Write};

use armbridge_client::params;
use armbridge_client::params::{Parameter, to_text};
use armbridge_log::text_table::{self, WIDTH};

use super::KEYS;

/// The file: every key, commented out.
pub fn explain() -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_all(&mut text);
    text
}

fn write_all(out: &mut String) -> Result {
    comment(
        out,
        "Configuration of armbridge, searched for in the working directory and its parents. \
         Options of a command override the environment, which overrides this file, which \
         overrides the defaults, the values shown here. Remove the # from a line, and from the \
         [table] above it, to set the key. Angles are in rad, torques in N m; two \
         values in a list are joint 1 and joint 2.",
    )?;
    let mut table = "";
    for key in KEYS {
        let (group, name) = key.key.split_once('.').unwrap_or(("", key.key));
        begin_table(out, &mut table, group)?;
        let mut about = format!("{} Takes {}.", key.about, key.takes);
        if let Some(variable) = key.variable {
            write!(about, " In the environment: {variable}.")?;
        }
        writeln!(out)?;
        comment(out, &about)?;
        value(out, name, &to_text(&key.default_value()), key.unit)?;
    }
    for parameter in params::all() {
        begin_table(out, &mut table, parameter.group())?;
        write_parameter(out, parameter)?;
    }
    Ok(())
}

fn write_parameter(out: &mut String, parameter: &Parameter) -> Result {
    let mut about = format!("{} Takes {}.", parameter.about, parameter.takes);
    if let Some((kind, with)) = parameter.goes_with() {
        write!(
            about,
            " Only with {} = \"{}\".",
            kind.name(),
            with.join("\" or \"")
        )?;
    }
    writeln!(out)?;
    comment(out, &about)?;
    let default = parameter.default_value();
    let default = default.as_ref().map_or_else(String::new, to_text);
    value(out, parameter.name(), &default, parameter.unit)
}

/// The head of a table, if another one has begun.
fn begin_table(out: &mut String, table: &mut &str, group: &'static str) -> Result {
    if *table != group {
        *table = group;
        writeln!(out, "\n\n# [{group}]")?;
        if !about_table(group).is_empty() {
            comment(out, about_table(group))?;
        }
    }
    Ok(())
}

fn about_table(group: &str) -> &'static str {
    match group {
        "record" => "Files kept of a run.",
        "setup" => {
            "From here on: the board's settings. Unspecified settings stay as the board has them."
        }
        "arm" => "The arm that controller and estimator believe in; by default the paper's.",
        "joint1" => "The servo of joint 1; `armbridge calibrate` finds these numbers.",
        "joint2" => "The servo of joint 2.",
        "limits" => "What the board allows before it switches torque off.",
        _ => "",
    }
}

fn value(out: &mut String, name: &str, value: &str, unit: &str) -> Result {
    let line = format!("# {name} = {value}");
    if unit.is_empty() {
        writeln!(out, "{line}")
    } else {
        writeln!(out, "{line:<40} # {unit}")
    }
}

/// A paragraph behind `#`, broken at spaces.
fn comment(out: &mut String, text: &str) -> Result {
    let words = std::iter::once("##").chain(text.split(' '));
    let mut lines = text_table::wrap(words, " ", WIDTH, "## ").into_iter();
    lines.try_for_each(|line| writeln!(out, "{line}"))
}
