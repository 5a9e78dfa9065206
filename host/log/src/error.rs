//! Errors of writing and of reading a log.

use std::path::PathBuf;

/// Reason for which a log file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// Error of the file system.
    #[error("cannot write {path}: {source}", path = path.display())]
    Io {
        /// File being written.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Error of the MCAP library.
    #[error("cannot write {path}: {source}", path = path.display())]
    Mcap {
        /// File being written.
        path: PathBuf,
        /// Error of the library.
        source: ::mcap::McapError,
    },
    /// The file ends before the run did.
    #[error("{0}")]
    Truncated(String),
    /// Error of the CSV library.
    #[error("cannot write {path}: {source}", path = path.display())]
    Csv {
        /// File being written.
        path: PathBuf,
        /// Error of the library.
        source: ::csv::Error,
    },
}

/// Reason for which a log cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {path}: {why}", path = path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Reason, and remedy.
    pub why: String,
}
