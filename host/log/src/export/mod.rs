//! Logs in other programs' formats: every column of every tick.
//!
//! | format      | file                    | opens in                            |
//! |-------------|-------------------------|-------------------------------------|
//! | [`csv`]     | one row per tick        | spreadsheets, everything            |
//! | `parquet`   | typed columns           | pandas, polars, `DuckDB`, MATLAB    |
//! | [`mat`]     | named, unit-annotated   | MATLAB, Octave, `SciPy`             |
//!
//! Parquet needs the feature `parquet`.
//!
//! [`mod@column`] has the columns. Nothing is interpolated or left out: a missing sample is
//! empty and has its reason, and `tick` jumps where records are missing.

pub mod column;
pub mod csv;
pub mod mat;
#[cfg(feature = "parquet")]
pub mod parquet;

use std::path::PathBuf;

use crate::LogError;
use crate::inspect::settings::Setting;
use crate::output_file::OutputFile;
use crate::recording::{ReadError, Row};
use crate::run_info::RunFacts;

/// Formats to choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// MAT-file of level 5.
    Mat,
}

impl Format {
    /// File extension.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Mat => "mat",
        }
    }
}

/// Description of the run.
#[derive(Clone, Debug)]
pub struct About<'a> {
    /// Facts of the run.
    pub facts: &'a RunFacts,
    /// Settings of the board.
    pub settings: Vec<Setting>,
    /// Damage of the log, each in one sentence.
    pub damage: &'a [String],
    /// The ticks have true states of a simulated arm.
    pub has_true_states: bool,
}

impl About<'_> {
    fn title(&self) -> String {
        let RunFacts { name, version, .. } = self.facts;
        format!("armbridge {version} {name}: {}", self.facts.describe())
    }

    fn damage_in_words(&self) -> String {
        if self.damage.is_empty() {
            return String::new();
        }
        format!("\nMissing of the log: {}", self.damage.join(" "))
    }

    #[cfg(feature = "parquet")]
    fn settings_json(&self) -> String {
        let settings = self.settings.iter();
        let settings: std::collections::BTreeMap<_, _> =
            settings.map(|s| (s.key, &s.value)).collect();
        // Plain data: always has a form in JSON.
        serde_json::to_string(&settings).unwrap_or_default()
    }
}

/// Reason for which a log could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The log cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Error of the file system.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// File being written.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Error of the CSV library.
    #[error(transparent)]
    Csv(#[from] LogError),
    /// Error of the Parquet library.
    #[cfg(feature = "parquet")]
    #[error("cannot write {path}: {source}", path = path.display())]
    Parquet {
        /// File being written.
        path: PathBuf,
        /// Error of the library.
        source: ::parquet::errors::ParquetError,
    },
    /// Parquet was left out of the program.
    #[error(
        "this build cannot write Parquet; \
         `cargo build --release --features parquet` makes one that can"
    )]
    NoParquet,
    /// More ticks than a MAT-file of level 5 holds.
    #[error(
        "cannot write {path}: {ticks} ticks are more than the 2 GiB of a variable in a .mat; \
         export parquet instead, which MATLAB's `parquetread` opens",
        path = path.display()
    )]
    TooLong {
        /// File that would have been written.
        path: PathBuf,
        /// Ticks of the log.
        ticks: u64,
    },
}

impl ExportError {
    /// Gives a complete file its name.
    fn finish(file: OutputFile) -> Result<PathBuf, Self> {
        let path = file.path().to_path_buf();
        file.finish().map_err(|source| Self::Write { path, source })
    }
}

/// Writes a log to a file; each call of `rows` iterates over its ticks.
/// Returns the file's path, which may have a number, and the number of ticks.
///
/// # Errors
/// If the log cannot be read or the file cannot be written.
pub fn write<I: Iterator<Item = Row>>(
    format: Format,
    file: OutputFile,
    about: &About<'_>,
    rows: impl Fn() -> Result<I, ExportError>,
) -> Result<(PathBuf, u64), ExportError> {
    match format {
        Format::Csv => csv::write(file, about.has_true_states, rows()?),
        #[cfg(feature = "parquet")]
        Format::Parquet => parquet::write(file, about, rows()?),
        #[cfg(not(feature = "parquet"))]
        Format::Parquet => Err(ExportError::NoParquet),
        Format::Mat => mat::write(file, about, rows),
    }
}
