//! `run.html`: a run as one self-contained page.
//!
//! It shows the moving arm, the curves, the events, the settings and the commands that repeat
//! the run. It needs no network, which its content security policy forbids, and is smaller
//! than 2 MB whatever the length of the run. Time is in s after the arm is armed.
//!
//! | file          | contents                                                        |
//! |---------------|-----------------------------------------------------------------|
//! | `collect`     | one pass over the log                                           |
//! | `rows`        | values over time in bounded memory                              |
//! | `events`      | commands, pushes, faults, modes, messages                       |
//! | `sent`        | a command and its replies                                       |
//! | `headline`    | the result in one sentence                                      |
//! | `data`, `pack` | the page's data: JSON with packed numbers                      |
//! | `document`    | HTML                                                            |
//! | `page.css`    | style                                                           |
//! | `data.js`     | reads the data                                                  |
//! | `arm.js`      | draws the arm                                                   |
//! | `plots.js`    | draws the curves; zoom                                          |
//! | `timeline.js` | overview with marks, playback, keys                             |
//! | `tables.js`   | events, settings, copying                                       |
//! | `main.js`     | state shared by them                                            |

mod collect;
mod data;
mod document;
mod events;
mod headline;
mod pack;
mod rows;
mod sent;

use std::path::{Path, PathBuf};

use armbridge_log::output_file::{self, Existing};
use armbridge_log::recording::ReadError;

use collect::Collected;
use data::PageData;

/// Name of the page's file.
pub const FILE: &str = "run.html";

/// Contents of the page beside the log.
#[derive(Clone, Debug)]
pub struct PageInput<'a> {
    /// Log of the run.
    pub log: &'a Path,
    /// Second run, drawn in grey.
    pub beside: Option<Beside<'a>>,
    /// The result in one sentence; none for one that is derived from the log.
    pub headline: Option<String>,
    /// Command that made the run, such as `armbridge run demo --seed 1`.
    pub made_by: Option<&'a str>,
}

/// A second run.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'a> {
    /// Its log.
    pub log: &'a Path,
    /// Its name, such as `the paper's control`.
    pub name: &'a str,
}

impl<'a> PageInput<'a> {
    /// The page of one log alone.
    pub fn of_log(log: &'a Path) -> Self {
        Self {
            log,
            beside: None,
            headline: None,
            made_by: None,
        }
    }
}

/// The page could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RunPageError {
    /// A log cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The page cannot be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// File being written.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
}

/// Writes the page into a folder; returns its path, which has a number if there is another
/// page already.
///
/// Damage of a log is shown in the page.
///
/// # Errors
/// If a log cannot be read or the page cannot be written.
pub fn write(folder: &Path, input: &PageInput<'_>) -> Result<PathBuf, RunPageError> {
    let (run, beside) = std::thread::scope(|scope| {
        let beside = input.beside.as_ref();
        let beside = beside.map(|beside| scope.spawn(|| Collected::read(beside.log)));
        let run = Collected::read(input.log);
        let beside = beside.map(|thread| {
            let joined = thread.join();
            joined.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        (run, beside)
    });
    let (run, beside) = (run?, beside.transpose()?);
    let data = PageData::new(input, &run, beside.as_ref()).json();
    let page = document::document(folder, input, &run, beside.as_ref(), &data);
    let path = folder.join(FILE);
    output_file::write(&path, page.as_bytes(), Existing::Number)
        .map_err(|source| RunPageError::Write { path, source })
}
