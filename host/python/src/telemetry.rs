//! Blocks of ticks as they arrive.

use std::sync::Arc;
use std::time::Duration;

use armbridge_client::telemetry::CAPACITY;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arguments::seconds;
use crate::block::Block;
use crate::connection::Connection;

/// Ticks of the board as they arrive. Up to 60 000 wait to be taken.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Telemetry(pub(crate) Arc<Connection>);

#[pymethods]
impl Telemetry {
    /// Waits for this many ticks and takes them, oldest first.
    #[pyo3(signature = (count, timeout = None))]
    fn take(&self, py: Python<'_>, count: usize, timeout: Option<f64>) -> PyResult<Block> {
        if count > CAPACITY {
            return Err(PyValueError::new_err(format!(
                "{count} ticks at once: at most {CAPACITY} wait"
            )));
        }
        let timeout = timeout.map_or(Ok(Duration::MAX), seconds)?;
        let records = self.0.call(py, |client| client.take(count, timeout))?;
        Ok(Block::new(records, Vec::new()))
    }

    /// Takes all ticks that wait.
    fn drain(&self, py: Python<'_>) -> PyResult<Block> {
        let telemetry = self.0.client()?.telemetry().clone();
        Ok(Block::new(py.detach(|| telemetry.drain()), Vec::new()))
    }

    /// Number of ticks that wait.
    #[getter]
    fn waiting(&self) -> PyResult<usize> {
        Ok(self.0.client()?.telemetry().waiting())
    }

    /// Number of ticks lost since the board was connected, on the link or because they were not taken.
    #[getter]
    fn lost(&self) -> PyResult<u64> {
        Ok(self.0.client()?.telemetry().lost())
    }
}
