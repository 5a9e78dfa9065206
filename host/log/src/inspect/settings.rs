//! The board's settings as a list of names with values, for tables and files, and the
//! differences of two boards' settings.

use armbridge_client::params;
use armbridge_client::params::Parameter;
use armbridge_link::message::Settings;
use serde::Serialize;

/// A setting with its name and unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Its name, as `limits.hold_ms`.
    pub key: &'static str,
    /// Its value.
    pub value: toml::Value,
    /// Unit, such as `rad`; empty for a number without one.
    pub unit: &'static str,
}

/// A setting that differs between two boards.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Differing {
    /// Its name.
    pub key: &'static str,
    /// Its value on each; none where it is not in use.
    pub values: [Option<toml::Value>; 2],
    /// Its unit.
    pub unit: &'static str,
}

/// All settings in use, in the order in which they are shown.
pub fn list(settings: &Settings) -> Vec<Setting> {
    let setting = |(parameter, value): (&'static Parameter, _)| Setting {
        key: parameter.key,
        value,
        unit: parameter.unit,
    };
    params::pairs(settings).into_iter().map(setting).collect()
}

/// The settings that differ.
pub fn differing(a: &Settings, b: &Settings) -> Vec<Differing> {
    let all = params::all().iter();
    let values = all.map(|parameter| Differing {
        key: parameter.key,
        values: [a, b].map(|settings| params::get(settings, parameter.key)),
        unit: parameter.unit,
    });
    values.filter(|d| d.values[0] != d.values[1]).collect()
}

impl Differing {
    /// The value on one of them, with its unit; `-` where it is not in use.
    pub fn show(&self, index: usize) -> String {
        let value = self.values[index].as_ref();
        let shown = value.map(|value| format!("{} {}", params::to_text(value), self.unit));
        shown.map_or_else(|| "-".to_owned(), |text| text.trim_end().to_owned())
    }
}
