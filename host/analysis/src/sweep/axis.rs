//! Keys of a sweep with their values, as typed: `controller.r=[10,10],[20,20]`, `seed=1..20`.

use std::collections::HashSet;
use std::fmt;

use armbridge_client::params;
use armbridge_link::message::Settings;
use armbridge_sim::plant::{PlantError, PlantFile};
use serde::Serialize;
use toml::Value;

use crate::plan_runner::plan::Base;
use crate::scenario::Overrides;

/// Largest number of runs, and so of values of a key and of combinations.
pub const RUNS_MAX: usize = 100_000;

/// Keys that are not parameters of the board.
const CONTROL: &str = "control";
const PLANT: &str = "plant";
const SEED: &str = "seed";

/// A key and its values.
#[derive(Clone, Debug, PartialEq)]
pub enum Axis {
    /// Seeds of the encoder noise.
    Seeds(Vec<u64>),
    /// Values of a key.
    Values(String, Vec<String>),
}

/// Text that is not a key with values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AxisError {
    /// There is no `=`, or nothing on a side of it.
    #[error(
        "`{0}` is not KEY=VALUE,VALUE, as controller.r=[10,10],[20,20], control=paper,compensated \
         or seed=1..20"
    )]
    NotValues(String),
    /// There is no such key.
    #[error("{0}; besides parameters there are `seed`, `control` and `plant`")]
    Unknown(params::ParameterError),
    /// A seed is no whole number from 0 up.
    #[error("`{0}` is no seed: expected whole numbers from 0 up, as seed=1..20 or seed=1,2,3")]
    Seed(String),
    /// Values of a parameter that takes lists are none.
    #[error("`{0}` takes lists: write each value in brackets, as controller.r=[10,10],[20,20]")]
    NotLists(String),
    /// A value is given twice: the same run would count twice.
    #[error("`{0}` has the value {1} twice")]
    Repeated(String, String),
    /// A range ends before it begins, or is too long.
    #[error("`{0}` is no range of 1 to {RUNS_MAX} whole numbers")]
    Range(String),
}

/// One value of a key.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Assignment {
    /// The key.
    pub key: String,
    /// Its value, as typed.
    pub value: String,
}

/// One value of each key.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Combination(pub Vec<Assignment>);

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs = self.0.iter();
        let pairs = pairs.map(|pair| format!("{}={}", pair.key, pair.value));
        f.write_str(&pairs.collect::<Vec<_>>().join(" "))
    }
}

impl std::str::FromStr for Axis {
    type Err = AxisError;

    fn from_str(text: &str) -> Result<Self, AxisError> {
        let not_values = || AxisError::NotValues(text.into());
        let (key, values) = text.split_once('=').ok_or_else(not_values)?;
        let (key, values) = (key.trim(), split(values));
        if key.is_empty() || values.is_empty() || values.iter().any(String::is_empty) {
            return Err(not_values());
        }
        let values: Result<Vec<_>, _> = values.iter().map(|value| range(value)).collect();
        let values: Vec<String> = values?.into_iter().flatten().collect();
        let is_list = |value: &String| params::of_text(value).is_array();
        if takes_lists(key) && !values.iter().all(is_list) {
            return Err(AxisError::NotLists(key.into()));
        }
        if let Some(value) = repeated(&values) {
            return Err(AxisError::Repeated(key.into(), value));
        }
        if key == SEED {
            let seed = |value: &String| value.parse().map_err(|_| AxisError::Seed(value.clone()));
            return Ok(Self::Seeds(
                values.iter().map(seed).collect::<Result<_, _>>()?,
            ));
        }
        if ![CONTROL, PLANT].contains(&key) && params::find(key).is_none() {
            return Err(AxisError::Unknown(params::unknown(key)));
        }
        Ok(Self::Values(key.into(), values))
    }
}

/// Whether a parameter is a list, of those in use by default.
fn takes_lists(key: &str) -> bool {
    params::get(&Settings::default(), key).is_some_and(|value| value.is_array())
}

/// The first value that is there before, in this form or another, as `[10, 10]` and `[10,10]`.
fn repeated(values: &[String]) -> Option<String> {
    let mut known = HashSet::with_capacity(values.len());
    let mut forms = values
        .iter()
        .map(|value| params::of_text(value).to_string());
    forms.find_map(|form| known.replace(form))
}

/// Values between commas that are not inside brackets.
fn split(text: &str) -> Vec<String> {
    let mut depth = 0_usize;
    let parts = text.split(|c: char| {
        match c {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        c == ',' && depth == 0
    });
    parts.map(|part| part.trim().to_owned()).collect()
}

/// `1..20` as all its numbers, both ends included; anything else as it is.
fn range(text: &str) -> Result<Vec<String>, AxisError> {
    let ends = text.split_once("..").and_then(|(first, last)| {
        let last = last.trim_start_matches('=');
        Some((first.parse::<u64>().ok()?, last.parse::<u64>().ok()?))
    });
    match ends {
        None => Ok(vec![text.into()]),
        Some((first, last)) if first <= last && last - first < RUNS_MAX as u64 => {
            Ok((first..=last).map(|number| number.to_string()).collect())
        }
        Some(_) => Err(AxisError::Range(text.into())),
    }
}

/// Every combination of the values, the last key changing fastest; `None` if they are more
/// than 100 000.
pub fn combinations(axes: &[(String, Vec<String>)]) -> Option<Vec<Combination>> {
    let count = axes.iter().try_fold(1_usize, |count, (_, values)| {
        count.checked_mul(values.len())
    });
    count.filter(|count| *count <= RUNS_MAX)?;
    let mut combinations = vec![Combination(Vec::new())];
    for (key, values) in axes {
        let longer = combinations.iter().flat_map(|Combination(before)| {
            values.iter().map(|value| {
                let (key, value) = (key.clone(), value.clone());
                let pairs = before.iter().cloned().chain([Assignment { key, value }]);
                Combination(pairs.collect())
            })
        });
        combinations = longer.collect();
    }
    Some(combinations)
}

/// Reason for which a combination has no overrides.
#[derive(Debug, thiserror::Error)]
pub enum ValueError {
    /// Not a name of a control.
    #[error("`control` cannot be {0}: it takes board, paper or compensated")]
    Control(String),
    /// There is no such virtual arm.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

impl Combination {
    /// The overrides of a run with these values: as on its command line.
    ///
    /// # Errors
    /// If there is no such control or virtual arm.
    pub fn overrides(&self, common: &Overrides) -> Result<Overrides, ValueError> {
        let mut overrides = common.clone();
        for Assignment { key, value } in &self.0 {
            match key.as_str() {
                CONTROL => {
                    let base = Base::from_name(value);
                    overrides.control =
                        Some(base.ok_or_else(|| ValueError::Control(value.clone()))?);
                }
                PLANT => overrides.plant = Some(PlantFile::load(value)?),
                _ => overrides.set.push((key.clone(), params::of_text(value))),
            }
        }
        Ok(overrides)
    }

    /// The value of a key as a number, if it is one.
    pub(super) fn number(&self, number: usize) -> Option<f64> {
        match params::of_text(&self.0.get(number)?.value) {
            Value::Integer(value) => Some(value as f64),
            Value::Float(value) => Some(value),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_separated_outside_brackets() {
        let axis: Axis = "controller.r=[10, 10],[20,20]".parse().unwrap();
        let values = vec!["[10, 10]".to_owned(), "[20,20]".to_owned()];
        assert_eq!(axis, Axis::Values("controller.r".into(), values));
        assert_eq!("seed=3..5,9".parse(), Ok(Axis::Seeds(vec![3, 4, 5, 9])));
        for (wrong, words) in [
            ("seed", "not KEY=VALUE"),
            ("seed=1,,2", "not KEY=VALUE"),
            ("seed=5..1", "no range"),
            ("seed=-1", "no seed"),
            ("seed=1,1", "`seed` has the value 1 twice"),
            ("seed=1..3,2", "`seed` has the value 2 twice"),
            (
                "controller.r=[1,1],[1, 1]",
                "`controller.r` has the value [1, 1] twice",
            ),
            ("controller.r=10,10", "write each value in brackets"),
            ("controller.Q=1", "is it `controller.q`"),
        ] {
            let error = wrong.parse::<Axis>().unwrap_err().to_string();
            assert!(error.contains(words), "{wrong}: {error}");
        }
    }

    #[test]
    fn the_last_key_changes_fastest() {
        let axis = |key: &str, values: &[&str]| {
            let values = values.iter().map(ToString::to_string).collect();
            (key.to_owned(), values)
        };
        let grid = combinations(&[axis("a", &["1", "2"]), axis("b", &["x", "y"])]).unwrap();
        let texts: Vec<String> = grid.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["a=1 b=x", "a=1 b=y", "a=2 b=x", "a=2 b=y"]);
        assert_eq!(combinations(&[]).unwrap().len(), 1);
        let many = vec!["1"; 1_000];
        assert_eq!(combinations(&[axis("a", &many), axis("b", &many)]), None);
    }
}
