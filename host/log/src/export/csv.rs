//! `.csv`: the table of a run folder's `run.csv`, of any log.

use std::path::PathBuf;

use super::ExportError;
use crate::CsvWriter;
use crate::output_file::OutputFile;
use crate::recording::Row;

/// Writes the file; returns its path, and how many ticks it has.
///
/// # Errors
/// If it cannot be written.
pub fn write(
    file: OutputFile,
    has_true_states: bool,
    rows: impl Iterator<Item = Row>,
) -> Result<(PathBuf, u64), ExportError> {
    let mut writer = CsvWriter::to(file, has_true_states)?;
    let mut ticks = 0;
    for row in rows {
        writer.row(&row)?;
        ticks += 1;
    }
    Ok((writer.finish()?, ticks))
}
