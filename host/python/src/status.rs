//! Status of the board.

use std::fmt::Write as _;

use armbridge_client::status::BoardStatus;
use armbridge_client::status_summary::StatusSummary;
use pyo3::prelude::*;

/// Status of a board: its mode, and what it reports of itself.
#[pyclass(frozen, get_all, module = "armbridge")]
#[derive(Debug)]
pub(crate) struct Status {
    /// Mode: `idle`, `armed`, `regulate`, `track`, `fault` and so on; None before the first tick.
    mode: Option<&'static str>,
    /// Name of the fault, in mode `fault`.
    fault: Option<&'static str>,
    /// Cause of the fault and what to do, in a sentence.
    cause: Option<String>,
    /// What the board lacks to be armed, in a sentence.
    obstacle: Option<String>,
    /// Whether the motors may be driven.
    is_armed: bool,
    /// Firmware of the servos, `Morpheus` or `stock`; None until they are found.
    servos: Option<String>,
    /// Estimated angles in rad.
    angle_rad: Option<(f32, f32)>,
    /// Estimated speeds in rad/s.
    speed_rad_s: Option<(f32, f32)>,
    /// Number of the latest tick.
    tick: Option<u32>,
    /// Temperatures of the servos: degrees Celsius of stock ones, converter counts of Morpheus.
    temperature: (Option<u16>, Option<u16>),
}

impl From<&BoardStatus> for Status {
    fn from(status: &BoardStatus) -> Self {
        let summary = StatusSummary::from(status);
        Self {
            mode: summary.mode,
            fault: summary.fault,
            cause: summary.cause,
            obstacle: summary.obstacle,
            is_armed: summary.is_armed,
            servos: summary.servos,
            angle_rad: summary.angle_rad.map(Into::into),
            speed_rad_s: summary.speed_rad_s.map(Into::into),
            tick: summary.tick,
            temperature: summary.temperature.into(),
        }
    }
}

#[pymethods]
impl Status {
    fn __repr__(&self) -> String {
        let mode = self.mode.unwrap_or("unknown");
        // Writing to a string cannot fail.
        let mut text = format!("<Status mode={mode}");
        if let Some((first, second)) = self.angle_rad {
            let _ = write!(text, " angle_rad=({first:.3}, {second:.3})");
        }
        for (name, value) in [
            ("fault", self.fault),
            ("cause", self.cause.as_deref()),
            ("obstacle", self.obstacle.as_deref()),
        ] {
            if let Some(value) = value {
                let _ = write!(text, " {name}={value:?}");
            }
        }
        text + ">"
    }
}
