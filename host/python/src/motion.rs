//! A motion under way.

use std::sync::Arc;

use armbridge_client::status::BoardStatus;
use armbridge_link::message::{Drive, Mode};
use armbridge_sim::link::ClientError;
use pyo3::prelude::*;

use crate::board::Connection;
use crate::errors::{DroppedError, FaultError, from_client};
use crate::telemetry::seconds;

/// Distance in rad, and speed in rad/s, at which the reference has arrived: rounding.
const ARRIVED: f32 = 1e-4;

/// A motion that the board has accepted.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Motion {
    pub(crate) connection: Arc<Connection>,
    pub(crate) goal_rad: [f32; 2],
    /// The tick before which it was accepted.
    pub(crate) after_tick: u32,
}

impl Motion {
    fn has_arrived(&self, status: &BoardStatus) -> bool {
        status.record.is_some_and(|record| {
            let output = &record.output;
            let joints = (0..2).all(|joint| {
                (output.reference_rad[joint] - self.goal_rad[joint]).abs() < ARRIVED
                    && output.reference_speed_rad_s[joint].abs() < ARRIVED
            });
            joints && record.tick.wrapping_sub(self.after_tick) as i32 > 1
        })
    }

    fn is_followed(status: &BoardStatus) -> bool {
        status.mode().and_then(Mode::drive) == Some(Drive::Track)
    }
}

#[pymethods]
impl Motion {
    /// Waits until the reference rests at the motion's end.
    #[pyo3(signature = (timeout = 30.0))]
    fn wait(&self, py: Python<'_>, timeout: f64) -> PyResult<()> {
        let (timeout, client) = (seconds(timeout)?, self.connection.client()?);
        let is_over = |status: &BoardStatus| {
            self.has_arrived(status)
                || (!Self::is_followed(status)
                    && status.record.is_some_and(|record| {
                        record.tick.wrapping_sub(self.after_tick) as i32 > 10
                    }))
        };
        let what = "the motion did not end";
        let waited = py.detach(|| client.wait_until(timeout, what, is_over));
        self.connection.result(py, waited)?;
        let status = client.status();
        match status.mode() {
            Some(Mode::Fault(fault)) => {
                let error = ClientError::Fault(fault, status.trip);
                Err(FaultError::new_err(
                    from_client(&error).value(py).to_string(),
                ))
            }
            _ if self.has_arrived(&status) => Ok(()),
            _ => Err(DroppedError::new_err("another command ended the motion")),
        }
    }

    /// Whether the reference rests at the motion's end.
    #[getter]
    fn done(&self) -> PyResult<bool> {
        Ok(self.has_arrived(&self.connection.client()?.status()))
    }
}
