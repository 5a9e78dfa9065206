//! The log of a run: everything that was said on the link, and nothing else.
//!
//! ```text
//! link --bytes--> Tap --> queue --> Ear --events--> Encoder --messages--> run.mcap
//!                                   |                                      |
//!                                   watch, live                Reader --events--> plot,
//!                                                                    export, replay
//! ```
//!
//! | module        | what                                                          |
//! |---------------|---------------------------------------------------------------|
//! | [`event`]     | what is said on a link, heard from its bytes                  |
//! | [`recorder`]  | writes it while the run goes on                               |
//! | [`recording`] | reads it back, as far as it goes                              |
//! | [`topics`]    | events as messages that viewers open                          |
//! | [`proto`]     | those messages; `host/proto/armbridge.proto` describes them   |
//! | [`clock`]     | the board's clock on the host's                               |
//! | [`raw`]       | the bytes themselves, kept beside what was made of them       |
//! | [`metadata`]  | what a log says about itself                                  |
//! | [`csv`]       | ticks as a table                                              |
//! | [`names`], [`words`] | one word for each thing, and sentences                 |

pub mod clock;
mod codes;
pub mod csv;
pub mod event;
mod exact;
mod file;
pub mod find;
pub mod metadata;
pub mod names;
pub mod overheard;
mod parameters;
mod pose;
pub mod proto;
mod queue;
pub mod raw;
mod reader;
pub mod recorder;
pub mod recording;
mod records;
mod said;
mod scribe;
mod statistics;
mod syncer;
mod telemetry;
pub mod topics;
pub mod words;

pub use csv::CsvWriter;

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
    /// The file ends before the run did.
    #[error("{0}")]
    BrokenOff(String),
    /// The CSV library said no.
    #[error("cannot write {path}: {source}", path = path.display())]
    Csv {
        /// File being written.
        path: PathBuf,
        /// What the library said.
        source: ::csv::Error,
    },
}
