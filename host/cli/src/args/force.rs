//! Whether files may be replaced.

use std::io::ErrorKind;
use std::path::Path;

use armbridge_log::output_file;
use armbridge_log::output_file::Existing;
use clap::Args;

/// Whether files may be replaced.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ForceArgs {
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

impl ForceArgs {
    /// Rule for a place that the user chose.
    pub(crate) fn chosen(self) -> Existing {
        if self.force {
            Existing::Replace
        } else {
            Existing::Refuse
        }
    }

    /// Rule for a place that is beside a log because the user chose none.
    pub(crate) fn beside_log(self) -> Existing {
        if self.force {
            Existing::Replace
        } else {
            Existing::Number
        }
    }

    /// Checks a place that the user chose, before the work whose result goes there.
    pub(crate) fn check(self, path: &Path) -> Result<(), String> {
        output_file::check(path, self.chosen()).map_err(|error| cannot_write(path, &error))
    }

    /// Removes a log that is in the way of another, which is written under its own name and
    /// replaces none; an error if it must stay.
    pub(crate) fn make_room(self, log: &Path) -> Result<(), String> {
        if !self.force {
            return self.check(log);
        }
        match std::fs::remove_file(log) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(cannot_write(log, &error)),
            Ok(()) | Err(_) => Ok(()),
        }
    }

    /// The rule for a place that the user chose, if there is one.
    pub(crate) fn existing<T>(self, place: Option<&T>) -> Existing {
        match place {
            Some(_) => self.chosen(),
            None => self.beside_log(),
        }
    }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write {}: {error}", path.display())
}
