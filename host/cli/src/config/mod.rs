//! Configuration: `armbridge.toml`, the environment, and defaults.
//!
//! The file is searched for in the working directory and its parents; the first one found
//! is taken. Options of a command override the environment, which overrides the file, which
//! overrides the defaults. A command passes its options:
//!
//! ```no_run
//! # use armbridge::config::Config;
//! # use armbridge_link::message::Settings;
//! # let (flag, of_the_board) = (None, Settings::default());
//! let config = Config::discover()?;
//! let link = config.link(flag)?;
//! let settings = config.settings(of_the_board)?;
//! # Ok::<(), armbridge::config::ConfigError>(())
//! ```
//!
//! The board's [parameters](armbridge_client::params) are keys of the file, their groups its tables;
//! those that the file does not name stay as the board has them.

mod explain;
mod keys;
#[cfg(test)]
mod tests;

pub use explain::explain;
pub use keys::{KEYS, Key};

use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{env, fmt};

use armbridge_client::params;
use armbridge_client::params::{InvalidSettings, ParameterError};
use armbridge_client::toml_file::{Document, DocumentError};
use armbridge_link::message::Settings;
use armbridge_sim::link::BoardUri;
use toml::Value;

/// Name of the file.
pub const FILE_NAME: &str = "armbridge.toml";

/// Why a configuration is invalid.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read, is no TOML, or has a key or a value that it must not have.
    #[error(transparent)]
    File(#[from] DocumentError),
    /// A variable of the environment has a value that it must not have.
    #[error("{variable}={value} in the environment: expected {expected}")]
    Environment {
        /// Its name.
        variable: &'static str,
        /// Its value.
        value: String,
        /// Accepted values, in words.
        expected: &'static str,
    },
    /// No board runs with the file's settings.
    #[error("{path}: {why}", path = path.display())]
    InvalidSettings {
        /// The file.
        path: PathBuf,
        /// Why not.
        why: InvalidSettings,
    },
}

/// Origin of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The default.
    Default,
    /// The file, in this line.
    File {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
    },
    /// This variable of the environment.
    Environment(&'static str),
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File { path, line } => write!(f, "{}:{line}", path.display()),
            Self::Environment(variable) => f.write_str(variable),
        }
    }
}

/// A key with the value that is in force.
#[derive(Clone, Debug, PartialEq)]
pub struct InForce {
    /// Its name.
    pub key: &'static str,
    /// Of the value.
    pub unit: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// Value in force.
    pub value: Value,
    /// Its origin.
    pub source: Source,
}

/// The configuration without the command line's options.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    file: Option<Document>,
    /// Values of [`KEYS`], in their order.
    own: Vec<(Value, Source)>,
}

impl Config {
    /// From the file that is found from the working directory upward, and from the
    /// environment.
    ///
    /// # Errors
    /// If one of them has an invalid key or value.
    pub fn discover() -> Result<Self, ConfigError> {
        let folder = env::current_dir().unwrap_or_default();
        Self::of(find_file(&folder).as_deref(), |variable| {
            env::var(variable).ok()
        })
    }

    /// From this file, or none, and these variables.
    ///
    /// # Errors
    /// If one of them has an invalid key or value.
    pub fn of(
        file: Option<&Path>,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, ConfigError> {
        let file = file.map(Document::read).transpose()?;
        if let Some(file) = &file {
            check_keys(file)?;
        }
        let own = KEYS.iter().map(|key| {
            if let Some(name) = key.variable
                && let Some(text) = variable(name).filter(|text| !text.is_empty())
            {
                let value = Value::String(text.clone());
                return if key.allows(&value) {
                    Ok((value, Source::Environment(name)))
                } else {
                    Err(ConfigError::Environment {
                        variable: name,
                        value: text,
                        expected: key.takes,
                    })
                };
            }
            let file_value = file.as_ref().and_then(|file| file_value(file, key.key));
            Ok(file_value.unwrap_or_else(|| (key.default_value(), Source::Default)))
        });
        let own = own.collect::<Result<_, _>>()?;
        Ok(Self { file, own })
    }

    /// The file, if there is one.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_ref().map(Document::path)
    }

    /// Link to the board; a command's option overrides it.
    ///
    /// # Errors
    /// If there is no such link, or a host of this name.
    pub fn link(&self, option: Option<&BoardUri>) -> Result<BoardUri, ConfigError> {
        if let Some(link) = option {
            return Ok(link.clone());
        }
        let (value, _) = self.own(keys::LINK);
        let text = value.as_str().unwrap_or_default();
        Ok(text.parse().unwrap_or(BoardUri::Sim))
    }

    /// For how long a broken link is tried again.
    pub fn patience(&self) -> Duration {
        let (value, _) = self.own(keys::PATIENCE_S);
        keys::seconds(value).map_or(Duration::ZERO, Duration::from_secs_f64)
    }

    /// Folder in which run folders are created; a command's option overrides it.
    pub fn out(&self, option: Option<&Path>) -> PathBuf {
        if let Some(out) = option {
            return out.into();
        }
        let (value, source) = self.own(keys::OUT);
        let out = Path::new(value.as_str().unwrap_or_default());
        match (source, self.file().and_then(Path::parent)) {
            (Source::File { .. }, Some(folder)) => folder.join(out),
            (Source::File { .. } | Source::Default | Source::Environment(_), _) => out.into(),
        }
    }

    /// Whether a run writes `run.csv`.
    pub fn writes_csv(&self) -> bool {
        self.is_on(keys::RECORD_CSV)
    }

    /// Whether a run draws its plots.
    pub fn draws_plots(&self) -> bool {
        self.is_on(keys::RECORD_PLOTS)
    }

    /// Settings of a board, overridden by the file's.
    ///
    /// # Errors
    /// If no board runs with them; or if the file has numbers of a kind of controller or
    /// estimator that neither it nor the board has.
    pub fn settings(&self, mut base: Settings) -> Result<Settings, ConfigError> {
        let Some(file) = &self.file else {
            return Ok(base);
        };
        let pairs = parameters(file).map(|(parameter, value)| (parameter.key, value));
        params::apply(&mut base, pairs).map_err(|error| wrong(file, &error))?;
        params::check(&base).map_err(|why| ConfigError::InvalidSettings {
            path: file.path().into(),
            why,
        })?;
        Ok(base)
    }

    /// The file's parameters of control: what a run takes whose control is the board's own.
    /// Model, calibration and limits stay the board's.
    pub fn control(&self) -> Vec<(String, Value)> {
        const GROUPS: [&str; 3] = ["setup", "controller", "estimator"];
        let pairs = self.file.iter().flat_map(parameters);
        pairs
            .filter(|(parameter, _)| GROUPS.contains(&parameter.group()))
            .map(|(parameter, value)| (parameter.key.to_owned(), value.clone()))
            .collect()
    }

    /// Whether the file has settings for the board.
    pub fn has_settings(&self) -> bool {
        self.file
            .as_ref()
            .is_some_and(|file| parameters(file).next().is_some())
    }

    /// All values in force: the host's own keys, and the file's settings for the board.
    pub fn in_force(&self) -> Vec<InForce> {
        let own = KEYS
            .iter()
            .zip(&self.own)
            .map(|(key, (value, source))| InForce {
                key: key.key,
                unit: key.unit,
                about: key.about,
                value: value.clone(),
                source: source.clone(),
            });
        let of_file = self.file.iter().flat_map(|file| {
            params::all().iter().filter_map(|parameter| {
                let (value, source) = file_value(file, parameter.key)?;
                Some(InForce {
                    key: parameter.key,
                    unit: parameter.unit,
                    about: parameter.about,
                    value,
                    source,
                })
            })
        });
        own.chain(of_file).collect()
    }

    fn own(&self, key: &str) -> &(Value, Source) {
        static NOTHING: (Value, Source) = (Value::Boolean(false), Source::Default);
        let mut own = KEYS.iter().zip(&self.own);
        own.find(|(known, _)| known.key == key)
            .map_or(&NOTHING, |(_, own)| own)
    }

    fn is_on(&self, key: &str) -> bool {
        let (value, _) = self.own(key);
        value.as_bool().unwrap_or_default()
    }
}

/// The file in this folder, or in the nearest one above it that has one.
pub fn find_file(folder: &Path) -> Option<PathBuf> {
    let mut files = folder.ancestors().map(|folder| folder.join(FILE_NAME));
    // A folder of this name is refused, not left out.
    files.find(|file| file.exists())
}

/// A key's value in a file, and its line.
fn file_value(file: &Document, key: &str) -> Option<(Value, Source)> {
    let entry = file.get(key)?;
    let source = Source::File {
        path: file.path().into(),
        line: file.place(entry.key_at.start).line,
    };
    Some((entry.value.clone(), source))
}

/// A file's settings for the board.
fn parameters(file: &Document) -> impl Iterator<Item = (&'static params::Parameter, &Value)> {
    file.entries()
        .filter_map(|(key, entry)| Some((params::find(key)?, &entry.value)))
}

/// Every key is one that there is, and its value one that it takes.
fn check_keys(file: &Document) -> Result<(), DocumentError> {
    for (key, entry) in file.entries() {
        let value = &entry.value;
        if let Some(own) = keys::find(key) {
            if !own.allows(value) {
                let expected = format!("`{key}` takes {}", own.takes);
                return Err(file.wrong_value(key, expected));
            }
        } else if let Some(parameter) = params::find(key) {
            let accepted = parameter.accepts(value);
            accepted.map_err(|error| file.wrong_value(key, error.to_string()))?;
        } else {
            let known = KEYS.iter().map(|key| key.key);
            let known = known.chain(params::all().iter().map(|parameter| parameter.key));
            let nearest = params::nearest(key, known);
            let meant = nearest.map_or_else(
                || "; `armbridge config --explain` lists all".to_owned(),
                |nearest| format!("; is it `{nearest}`?"),
            );
            return Err(file.wrong_key(key, format!("there is no key `{key}`{meant}")));
        }
    }
    Ok(())
}

fn wrong(file: &Document, error: &ParameterError) -> DocumentError {
    file.wrong_key(error.key(), error.to_string())
}
