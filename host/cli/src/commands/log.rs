//! The log that a command reads: the named one, or the newest run's.

use std::path::{Path, PathBuf};

use armbridge::config::Config;
use armbridge_log::log_path;

use super::Error;

/// The log at this path, or in this folder; without one, the newest run's in the configured
/// folder for runs.
pub(crate) fn find(given: Option<&Path>) -> Result<PathBuf, Error> {
    // A log that is named is found whatever the configuration.
    let runs = match given {
        Some(_) => PathBuf::new(),
        None => Config::discover()?.out(None),
    };
    Ok(log_path::find(given, &runs)?)
}
