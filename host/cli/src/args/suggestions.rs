//! Values that a shell completes, of options that take others as well.
//!
//! A parser with possible values would refuse all others; these parsers only suggest them.

use std::ffi::OsStr;
use std::sync::LazyLock;

use armbridge_analysis::scenario::BUILTINS;
use armbridge_client::params;
use armbridge_sim::plant::PLANTS;
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use toml::Value;

/// The beginnings of `KEY=VALUE`.
static ASSIGNMENTS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let keys = params::all().iter();
    keys.map(|parameter| format!("{}=", parameter.key))
        .collect()
});

/// A parser with suggestions for the shell.
#[derive(Clone)]
pub(crate) struct Suggested<T: Clone> {
    values: fn() -> Vec<&'static str>,
    parse: fn(&str) -> Result<T, String>,
}

/// Names of the scenarios that ship.
pub(crate) fn scenario_names() -> Vec<&'static str> {
    BUILTINS.iter().map(|builtin| builtin.name).collect()
}

/// Names of the virtual arms that ship.
pub(crate) fn plant_names() -> Vec<&'static str> {
    PLANTS.iter().map(|plant| plant.name).collect()
}

/// A scenario: the name of one that ships, or a file.
pub(crate) fn scenarios() -> Suggested<String> {
    Suggested {
        values: scenario_names,
        parse: |text| Ok(text.into()),
    }
}

/// A virtual arm: the name of one that ships, or a file.
pub(crate) fn plants() -> Suggested<String> {
    Suggested {
        values: plant_names,
        parse: |text| Ok(text.into()),
    }
}

/// A key of a sweep and its values, as `seed=1..20`.
pub(crate) fn axes() -> Suggested<String> {
    Suggested {
        values: || {
            let others = ["control=", "plant=", "seed="].into_iter();
            others
                .chain(ASSIGNMENTS.iter().map(String::as_str))
                .collect()
        },
        parse: |text| Ok(text.into()),
    }
}

/// A parameter of the board, with or without a value, or a group of them.
pub(crate) fn keys() -> Suggested<String> {
    Suggested {
        values: || {
            params::all()
                .iter()
                .map(|parameter| parameter.key)
                .collect()
        },
        parse: |text| Ok(text.into()),
    }
}

/// A parameter of the board and its value, as `limits.hold_ms=80`.
pub(crate) fn parameters() -> Suggested<(String, Value)> {
    Suggested {
        values: || ASSIGNMENTS.iter().map(String::as_str).collect(),
        parse: |text| params::pair(text).map_err(|error| error.to_string()),
    }
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for Suggested<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let parse = self.parse;
        let text = StringValueParser::new().parse_ref(command, argument, value)?;
        parse(&text).map_err(|why| {
            let option = argument.map_or_else(String::new, ToString::to_string);
            let message = format!("invalid value '{text}' for '{option}': {why}\n");
            command.clone().error(ErrorKind::ValueValidation, message)
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let values = (self.values)();
        Some(Box::new(values.into_iter().map(PossibleValue::new)))
    }
}
