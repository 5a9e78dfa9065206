//! Logs as arrays, and their replay.

use std::path::PathBuf;

use armbridge_log::recording::Reader;
use armbridge_log::replay::{Changes, Replayer, Report, Verdict};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::block::Block;
use crate::errors::{log_error, value_error};
use crate::settings;

/// A log in memory, as far as its first damage.
#[pyclass(frozen, mapping, module = "armbridge")]
pub(crate) struct Log {
    path: PathBuf,
    block: Py<Block>,
    settings: Option<armbridge_link::message::Settings>,
    damage: Vec<String>,
}

#[pymethods]
impl Log {
    /// Reads a log; a folder means the log in it.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let (records, truths, reader) = py
            .detach(|| {
                let reader = Reader::open(&path)?;
                let mut rows = reader.rows();
                let (mut records, mut truths) = (Vec::new(), Vec::new());
                for row in rows.by_ref() {
                    // A real arm has none.
                    if row.truth.is_some() || !truths.is_empty() {
                        truths.resize(records.len(), None);
                        truths.push(row.truth);
                    }
                    records.push(row.record);
                }
                Ok((records, truths, rows))
            })
            .map_err(|error: armbridge_log::recording::ReadError| log_error(error))?;
        let reader = reader.reader();
        Ok(Self {
            path: reader.path().to_path_buf(),
            settings: reader.settings().copied(),
            damage: reader.damage().to_vec(),
            block: Py::new(py, Block::new(vec![records], truths))?,
        })
    }

    fn __len__(&self) -> usize {
        self.block.get().len()
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        Ok(self.block.bind(py).get_item(name)?.unbind())
    }

    fn __contains__(&self, py: Python<'_>, name: &str) -> PyResult<bool> {
        self.block.bind(py).contains(name)
    }

    fn __iter__(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self.block.bind(py).try_iter()?.into_any().unbind())
    }

    fn __repr__(&self) -> String {
        format!(
            "<Log {} of {} ticks>",
            self.path.display(),
            self.block.get().len()
        )
    }

    /// Names of the quantities.
    fn keys<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.block.bind(py).call_method0("keys")
    }

    /// Unit of a quantity, as `rad`; empty for words and plain numbers.
    fn unit<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        self.block.bind(py).call_method1("unit", (name,))
    }

    /// A table with one column for each quantity and joint, as in the Parquet export.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Block::to_pandas(self.block.bind(py))
    }

    /// Path of the log.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// Damage of the file, each in one sentence; empty for an intact one.
    #[getter]
    fn damage(&self) -> Vec<String> {
        self.damage.clone()
    }

    /// Parameters of the board by name: in force when the motors were first driven, else the last;
    /// None if the log has none.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.settings
            .as_ref()
            .map(|it| settings::to_dict(py, it))
            .transpose()
    }

    /// Runs the board's code on the recorded inputs, and compares its outputs to the bit.
    fn replay(&self, py: Python<'_>) -> PyResult<Replay> {
        let report = py.detach(|| {
            let mut reader = Reader::open(&self.path).map_err(log_error)?;
            let mut player = Replayer::new(Changes::default()).map_err(value_error)?;
            for event in &mut reader {
                player.take(&event).map_err(value_error)?;
            }
            player.finish().map_err(value_error)
        })?;
        Ok(Replay(report))
    }
}

/// Result of a replay.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Replay(Report);

#[pymethods]
impl Replay {
    /// Whether every compared tick and answer is equal to the bit.
    #[getter]
    fn equal(&self) -> bool {
        self.0.verdict == Verdict::Equal
    }

    /// Number of ticks that were compared.
    #[getter]
    fn compared(&self) -> u64 {
        self.0.compared
    }

    /// Number of those that differ.
    #[getter]
    fn differing(&self) -> u64 {
        self.0.differing
    }

    /// The first difference, in a sentence.
    #[getter]
    fn first_difference(&self) -> Option<String> {
        self.0.first.as_ref().map(ToString::to_string)
    }

    fn __repr__(&self) -> String {
        format!("<Replay {}>", self.0.text().trim_end().replace('\n', "; "))
    }
}
