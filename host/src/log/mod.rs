//! Log files of a run: every tick, in two forms.
//!
//! | file       | writer        | for                                            |
//! |------------|---------------|------------------------------------------------|
//! | `run.mcap` | [`McapWriter`]| Foxglove, `PlotJuggler`, replay: nothing is lost |
//! | `run.csv`  | [`CsvWriter`] | spreadsheets, pandas, Matlab                   |
//!
//! Both hold each record completely: [`message::TickMessage`] and
//! [`csv::Row`] convert to and from
//! [`Record`](armbridge_shared::link::message::Record) without loss.

pub mod csv;
pub mod mcap;
pub mod message;
pub mod names;

pub use csv::CsvWriter;
pub use mcap::McapWriter;

use std::path::PathBuf;

/// Why a log file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file system said no.
    #[error("cannot write {path}: {source}", path = path.display())]
    Io {
        /// File being written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The MCAP library said no.
    #[error("cannot write {path}: {source}", path = path.display())]
    Mcap {
        /// File being written.
        path: PathBuf,
        /// What the library said.
        source: ::mcap::McapError,
    },
    /// The CSV library said no.
    #[error("cannot write {path}: {source}", path = path.display())]
    Csv {
        /// File being written.
        path: PathBuf,
        /// What the library said.
        source: ::csv::Error,
    },
    /// A record could not be put into JSON.
    #[error("cannot encode a record for {path}: {source}", path = path.display())]
    Json {
        /// File being written.
        path: PathBuf,
        /// What the library said.
        source: serde_json::Error,
    },
}
