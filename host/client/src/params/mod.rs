//! The board's settings as names with values: one table for the configuration file,
//! `armbridge params`, scenarios, the log and the viewer.
//!
//! Keys are dotted and carry their unit: `limits.hold_ms`, `arm.l1_m`, `joint1.zero_count`,
//! `controller.q`. The parameters of a controller or an estimator depend on its kind:
//! `controller.kind = "lqr"` has `controller.q` and `controller.r`, and setting another
//! kind selects its own numbers, at their defaults.
//!
//! Values are TOML's. All values of some settings, set one after the other in the order of
//! [`all`], make the same settings, to the bit.
//!
//! | file       | contents                                               |
//! |------------|--------------------------------------------------------|
//! | `tables`   | the table: key, unit, range, meaning, and where it is  |
//! | `constraint` | permitted values: count and range                    |
//! | `access`   | from settings to values and back                       |
//! | `poles`    | observer poles as numbers and as text                  |
//! | `text`     | values as typed and shown                              |
//! | `check`    | checks of settings as a whole                          |
//! | `settings_exchange` | read from a board, and written to it                   |

mod access;
mod check;
mod constraint;
mod poles;
pub mod settings_exchange;
mod tables;
#[cfg(test)]
mod tests;
mod text;

pub use check::{InvalidSettings, ReplaceError, check, replaced};
pub use constraint::{Range, Shape, Takes};
pub use poles::{JointPoles, complex_numbers, joint_poles};
pub use text::{NotAPair, of_text, pair, to_text};

use std::sync::LazyLock;

use armbridge_link::message::Settings;
use toml::Value;

use access::Access;

/// Description of a parameter.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub key: &'static str,
    /// As `rad`, `N m`, `ms`; empty for a number without one.
    pub unit: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// Permitted values.
    pub takes: Takes,
    access: Access,
}

/// Reason for which a parameter cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// There is no such parameter.
    #[error("there is no parameter `{key}`{}", nearest.map_or_else(|| "; `armbridge params --all` lists them".to_owned(), |key| format!("; is it `{key}`?")))]
    Unknown {
        /// Requested name.
        key: String,
        /// The most similar name.
        nearest: Option<&'static str>,
    },
    /// The value is not permitted.
    #[error("`{key}` cannot be {value}: it takes {expected}")]
    Value {
        /// Name of the parameter.
        key: &'static str,
        /// The value.
        value: String,
        /// Permitted values.
        expected: String,
    },
    /// It belongs to another kind of controller or estimator.
    #[error("`{key}` goes with {kind} = {needed}, but that is \"{is}\"; set `{kind}` too")]
    NotInUse {
        /// Name of the parameter.
        key: &'static str,
        /// The parameter that selects the kind.
        kind: &'static str,
        /// Selected kind.
        is: String,
        /// Kinds with this parameter.
        needed: String,
    },
}

impl ParameterError {
    /// Name of the parameter.
    pub fn key(&self) -> &str {
        match self {
            Self::Unknown { key, .. } => key,
            Self::Value { key, .. } | Self::NotInUse { key, .. } => key,
        }
    }
}

/// All of them, in the order in which they are shown and must be set.
pub fn all() -> &'static [Parameter] {
    static ALL: LazyLock<Vec<Parameter>> = LazyLock::new(tables::all);
    &ALL
}

/// The parameter of this name.
pub fn find(key: &str) -> Option<&'static Parameter> {
    all().iter().find(|parameter| parameter.key == key)
}

/// The value of one; `None` if there is none of this name or it is not in use.
pub fn get(settings: &Settings, key: &str) -> Option<Value> {
    find(key)?.value(settings)
}

/// Changes one.
///
/// # Errors
/// If there is no such parameter, or the value is not permitted.
pub fn set(settings: &mut Settings, key: &str, value: &Value) -> Result<(), ParameterError> {
    find(key)
        .ok_or_else(|| unknown(key))?
        .set_value(settings, value)
}

/// All that are in use, with their values.
pub fn pairs(settings: &Settings) -> Vec<(&'static Parameter, Value)> {
    let pairs = all().iter();
    pairs
        .filter_map(|parameter| Some((parameter, parameter.value(settings)?)))
        .collect()
}

/// Parameters that are in use in `after` and differ from `before`: those to set to get
/// from one to the other.
pub fn changed(before: &Settings, after: &Settings) -> Vec<(&'static Parameter, Value)> {
    let mut pairs = pairs(after);
    pairs.retain(|(parameter, value)| parameter.value(before).as_ref() != Some(value));
    pairs
}

/// Changes several at once, kinds first, in any order; all of them or none.
///
/// # Errors
/// At the first that is not permitted.
pub fn apply<'a>(
    settings: &mut Settings,
    pairs: impl IntoIterator<Item = (&'a str, &'a Value)>,
) -> Result<(), ParameterError> {
    let place = |key: &str| all().iter().position(|parameter| parameter.key == key);
    let mut pairs: Vec<_> = pairs
        .into_iter()
        .map(|(key, value)| Ok((place(key).ok_or_else(|| unknown(key))?, value)))
        .collect::<Result<_, _>>()?;
    pairs.sort_by_key(|(place, _)| *place);
    let mut changed = *settings;
    for (place, value) in pairs {
        all()[place].set_value(&mut changed, value)?;
    }
    *settings = changed;
    Ok(())
}

/// Changes all that a table of tables names: `[controller] q = ...` is `controller.q`.
///
/// # Errors
/// At the first that is not permitted; nothing is changed then.
pub fn apply_table(settings: &mut Settings, table: &toml::Table) -> Result<(), ParameterError> {
    let mut pairs = Vec::new();
    flatten("", table, &mut pairs);
    let pairs = pairs.iter().map(|(key, value)| (key.as_str(), *value));
    apply(settings, pairs)
}

/// Parameters and values as a table of tables.
pub fn to_table<'a>(pairs: impl IntoIterator<Item = (&'a Parameter, Value)>) -> toml::Table {
    let mut groups = toml::Table::new();
    for (parameter, value) in pairs {
        let group = groups
            .entry(parameter.group())
            .or_insert_with(|| Value::Table(toml::Table::new()));
        if let Value::Table(group) = group {
            group.insert(parameter.name().to_owned(), value);
        }
    }
    groups
}

/// Error of a name that does not exist.
pub fn unknown(key: &str) -> ParameterError {
    ParameterError::Unknown {
        key: key.to_owned(),
        nearest: nearest(key, all().iter().map(|parameter| parameter.key)),
    }
}

/// The most similar name, if one is similar enough.
pub fn nearest<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Below, two names have little in common.
    const ALIKE: f64 = 0.75;

    // A key in capitals is still that key.
    let name = name.to_lowercase();
    let score = |known: &str| {
        let known = known.to_lowercase();
        // Two letters of a short name that are swapped leave it little in common.
        let is_slip = name.len() > 2 && strsim::osa_distance(&name, &known) == 1;
        let alike = strsim::jaro_winkler(&name, &known);
        if is_slip { alike.max(ALIKE) } else { alike }
    };
    let scored = names.into_iter().map(|known| (score(known), known));
    scored
        .filter(|(score, _)| *score >= ALIKE)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, known)| known)
}

fn flatten<'a>(prefix: &str, table: &'a toml::Table, pairs: &mut Vec<(String, &'a Value)>) {
    for (name, value) in table {
        let key = format!("{prefix}{name}");
        if let Value::Table(table) = value {
            flatten(&format!("{key}."), table, pairs);
        } else {
            pairs.push((key, value));
        }
    }
}

impl Parameter {
    /// Its first part, as `controller`.
    pub fn group(&self) -> &'static str {
        self.key.split_once('.').map_or("", |(group, _)| group)
    }

    /// Its second part, as `q`.
    pub fn name(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(_, name)| name)
    }

    /// The kinds of its group that it goes with, and the parameter that chooses between
    /// them; `None` if it is always in use.
    pub fn goes_with(&self) -> Option<(&'static Parameter, Vec<&'static str>)> {
        let default = Settings::default();
        let kind = find(&format!("{}.kind", self.group()))?;
        let kinds = kind.choices();
        let with: Vec<_> = kinds
            .iter()
            .copied()
            .filter(|name| self.value(&kind.with_choice(default, name)).is_some())
            .collect();
        (with.len() < kinds.len()).then_some((kind, with))
    }

    /// Its value in the default settings, of the kind that it goes with.
    pub fn default_value(&self) -> Option<Value> {
        let default = Settings::default();
        self.value(&default).or_else(|| {
            let (kind, with) = self.goes_with()?;
            self.value(&kind.with_choice(default, with.first()?))
        })
    }
}
