//! Blocks of ticks as they arrive.

use std::sync::Arc;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;

use crate::block::Block;
use crate::board::Connection;
use crate::errors::LinkError;

/// Period at which a call that waits looks for signals.
const LOOK: Duration = Duration::from_millis(50);

/// Ticks of the board as they arrive. Up to 60 000 wait to be taken.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Telemetry(pub(crate) Arc<Connection>);

#[pymethods]
impl Telemetry {
    /// Waits for this many ticks and takes them, oldest first.
    #[pyo3(signature = (count, timeout = None))]
    fn take(&self, py: Python<'_>, count: usize, timeout: Option<f64>) -> PyResult<Block> {
        let telemetry = self.0.client()?.telemetry().clone();
        if count > armbridge_client::telemetry::CAPACITY {
            return Err(PyValueError::new_err(format!(
                "{count} ticks at once: at most {} wait",
                armbridge_client::telemetry::CAPACITY
            )));
        }
        let until = timeout
            .map(seconds)
            .transpose()?
            .map(|it| Instant::now() + it);
        loop {
            let left = until.map_or(LOOK, |it| it.saturating_duration_since(Instant::now()));
            let taken = py.detach(|| telemetry.take(count, left.min(LOOK)));
            if let Some(records) = taken {
                return Ok(Block::new(records, Vec::new()));
            }
            py.check_signals()?;
            if telemetry.is_closed() {
                let waiting = telemetry.waiting();
                return Err(LinkError::new_err(format!(
                    "the link has ended; {waiting} ticks are left, which `drain` takes"
                )));
            }
            if left.is_zero() {
                return Err(PyTimeoutError::new_err(format!(
                    "{} of {count} ticks came in time; they wait",
                    telemetry.waiting()
                )));
            }
        }
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

/// A time span in s.
pub(crate) fn seconds(value: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(value)
        .map_err(|_| PyValueError::new_err(format!("expected a time in s, got {value}")))
}
