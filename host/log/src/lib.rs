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
//! | [`recorder`]  | writes it while the run goes on                               |
//! | [`recording`] | reads it back, as far as it goes                              |
//! | [`topics`]    | events as messages that viewers open                          |
//! | [`proto`]     | those messages; `host/log/proto/armbridge.proto` describes them |
//! | [`clock_sync`]     | the board's clock on the host's                               |
//! | [`raw_link_bytes`]       | the bytes themselves, kept beside what was made of them       |
//! | [`metadata`]  | what a log says about itself                                  |
//! | [`run_info`]  | what one has to know about a run to read its records          |
//! | [`csv`]       | ticks as a table                                              |
//! | [`export`]    | ticks in other programs' formats                              |
//! | [`summary`]   | a run in a few numbers                                        |
//! | [`inspect`]   | what a log holds, and where two differ                        |
//! | [`replay`]    | a log's inputs through the board's code                       |
//! | [`event_text`]     | events in sentences                                           |
//! | [`text_table`]     | plain tables for a terminal                                   |
#![forbid(unsafe_code)]

pub mod clock_sync;
pub mod csv;
mod enum_codes;
mod event_messages;
pub mod event_text;
pub mod export;
mod fsync_thread;
pub mod inspect;
pub mod log_path;
mod mcap_file;
pub mod metadata;
mod parameters;
mod payload_codec;
pub mod proto;
mod queue;
pub mod raw_link_bytes;
mod reader;
pub mod recorder;
pub mod recording;
mod records;
pub mod replay;
pub mod run_info;
mod statistics;
pub mod summary;
mod telemetry;
pub mod text_table;
pub mod topics;
mod visualization;
mod writer_thread;

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
