//! `.csv`: the table of a run folder's `run.csv`, of any log.

use std::path::Path;

use armbridge_shared::link::message::Record;

use super::ExportError;
use crate::CsvWriter;

/// Writes the file; returns how many ticks it has.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, records: impl Iterator<Item = Record>) -> Result<u64, ExportError> {
    let mut writer = CsvWriter::create(path)?;
    let mut ticks = 0;
    for record in records {
        writer.record(&record)?;
        ticks += 1;
    }
    writer.finish()?;
    Ok(ticks)
}
