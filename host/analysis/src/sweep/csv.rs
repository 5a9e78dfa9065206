//! All runs of a sweep as CSV: a column for each key, the seed, and the figures.

use std::io;
use std::io::Write;
use std::path::{Path, PathBuf};

use armbridge_log::output_file::{Existing, OutputFile};

use super::Sweep;

/// The file cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}", path = path.display())]
pub struct CsvError {
    /// The file.
    pub path: PathBuf,
    /// Error of the system.
    pub source: io::Error,
}

/// Columns after those of the keys. An empty field does not apply to the scenario; `inf`
/// is a settling time of never.
const COLUMNS: [&str; 8] = [
    "seed",
    "settling_time_s",
    "rest_error_mrad",
    "tracking_rms_mrad",
    "peak_torque_nm",
    "fault",
    "missed_expectations",
    "ended",
];

pub(super) fn write(sweep: &Sweep, path: &Path) -> Result<(), CsvError> {
    let written = || {
        let mut file = OutputFile::create(path, Existing::Refuse)?;
        write_rows(sweep, &mut csv::Writer::from_writer(&mut file))?;
        file.finish()
    };
    written().map(drop).map_err(|source| CsvError {
        path: path.into(),
        source,
    })
}

fn write_rows<W: Write>(sweep: &Sweep, file: &mut csv::Writer<W>) -> Result<(), csv::Error> {
    let keys = sweep.keys.iter().map(String::as_str);
    file.write_record(keys.chain(COLUMNS))?;
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    for run in &sweep.runs {
        let figures = &run.figures;
        let combination = sweep.combinations.get(run.combination);
        let values = combination
            .into_iter()
            .flat_map(|combination| &combination.0);
        let row = values.map(|pair| pair.value.clone()).chain([
            run.seed.to_string(),
            number(figures.settling_s()),
            number(figures.rest_error_mrad),
            number(figures.tracking_rms_mrad),
            figures.peak_torque_nm.to_string(),
            figures.fault.unwrap_or_default().to_owned(),
            figures.missed_expectations.join("; "),
            figures.ended.clone().unwrap_or_default(),
        ]);
        file.write_record(row)?;
    }
    file.flush()?;
    Ok(())
}
