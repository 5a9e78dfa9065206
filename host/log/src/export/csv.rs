//! `.csv`: the table of a run folder's `run.csv`, of any log.

use std::path::Path;

use super::ExportError;
use crate::CsvWriter;
use crate::recording::Row;

/// Writes the file; returns how many ticks it has.
///
/// # Errors
/// If it cannot be written.
pub fn write(
    path: &Path,
    has_true_states: bool,
    rows: impl Iterator<Item = Row>,
) -> Result<u64, ExportError> {
    let mut writer = CsvWriter::create(path, has_true_states)?;
    let mut ticks = 0;
    for row in rows {
        writer.row(&row)?;
        ticks += 1;
    }
    writer.finish()?;
    Ok(ticks)
}
