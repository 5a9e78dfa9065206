//! A motion under way.

use std::sync::Arc;

use armbridge_sim::link::ActiveMotion;
use pyo3::prelude::*;

use crate::arguments::seconds;
use crate::connection::Connection;

/// A motion that the board has accepted.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Motion(pub(crate) Arc<Connection>, pub(crate) ActiveMotion);

#[pymethods]
impl Motion {
    /// Waits until the reference rests at the motion's end.
    #[pyo3(signature = (timeout = 30.0))]
    fn wait(&self, py: Python<'_>, timeout: f64) -> PyResult<()> {
        let timeout = seconds(timeout)?;
        self.0.call(py, |client| client.wait_for(&self.1, timeout))
    }

    /// Whether the reference rests at the motion's end.
    #[getter]
    fn done(&self) -> PyResult<bool> {
        Ok(self.1.has_arrived(&self.0.client()?.status()))
    }
}
