//! Keys of `armbridge.toml` that are the host's own; the others are the board's
//! [parameters](armbridge_client::params).

use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_sim::link::{BoardUri, CHOICES};
use toml::Value;

/// One of the host's own keys.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub key: &'static str,
    /// As `s`; empty for a value that is no number.
    pub unit: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// Accepted values, in words.
    pub takes: &'static str,
    /// The variable of the environment that has the same meaning.
    pub variable: Option<&'static str>,
    default: fn() -> Value,
    check: fn(&Value) -> bool,
}

/// Longest that a broken link can be tried again, in s: a day.
const PATIENCE_MAX_S: f64 = 86_400.0;

pub(super) const LINK: &str = "link";
pub(super) const PATIENCE_S: &str = "patience_s";
pub(super) const OUT: &str = "out";
pub(super) const RECORD_CSV: &str = "record.csv";
pub(super) const RECORD_PLOTS: &str = "record.plots";

/// All of them, those without a table first.
pub const KEYS: [Key; 5] = [
    Key {
        key: LINK,
        unit: "",
        about: "Where the board is.",
        takes: CHOICES,
        variable: Some("ARMBRIDGE_LINK"),
        default: || "sim:".into(),
        check: |value| {
            value
                .as_str()
                .is_some_and(|uri| uri.parse::<BoardUri>().is_ok())
        },
    },
    Key {
        key: PATIENCE_S,
        unit: "s",
        about: "For how long a broken link is tried again.",
        takes: "a number from 0 to 86400",
        variable: None,
        default: || Value::Float(10.0),
        check: |value| seconds(value).is_some_and(|s| (0.0..=PATIENCE_MAX_S).contains(&s)),
    },
    Key {
        key: OUT,
        unit: "",
        about: "Folder in which the folders of runs are made; a relative one is relative to this \
                file.",
        takes: "a path",
        variable: Some("ARMBRIDGE_OUT"),
        default: || DEFAULT_BASE.into(),
        check: |value| value.as_str().is_some_and(|path| !path.is_empty()),
    },
    Key {
        key: RECORD_CSV,
        unit: "",
        about: "Whether a run in virtual time writes run.csv beside its log.",
        takes: "true or false",
        variable: None,
        default: || false.into(),
        check: Value::is_bool,
    },
    Key {
        key: RECORD_PLOTS,
        unit: "",
        about: "Whether a run draws its plots.",
        takes: "true or false",
        variable: None,
        default: || true.into(),
        check: Value::is_bool,
    },
];

/// The one of this name.
pub(super) fn find(key: &str) -> Option<&'static Key> {
    KEYS.iter().find(|known| known.key == key)
}

/// A number, written with a point or without.
pub(super) fn seconds(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|s| s as f64);
    value.as_float().or(whole)
}

impl Key {
    /// The default.
    pub fn default_value(&self) -> Value {
        (self.default)()
    }

    /// Whether it takes this value.
    pub(super) fn allows(&self, value: &Value) -> bool {
        (self.check)(value)
    }
}
