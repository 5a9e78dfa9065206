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

    /// Removes a file that is in the way of one that replaces none, such as a log or a
    /// picture; an error if it must stay.
    pub(crate) fn make_room(self, path: &Path) -> Result<(), String> {
        let removed = if self.force {
            std::fs::remove_file(path)
        } else {
            output_file::check(path, Existing::Refuse)
        };
        match removed {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(format!("cannot write {}: {error}", path.display()))
            }
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
