//! Status of the board.

use std::fmt::Write as _;

use armbridge_client::status::BoardStatus;
use armbridge_client::{enum_names, fault_text};
use armbridge_link::message::Mode;
use pyo3::prelude::*;

/// Status of a board: its mode, and what it reports of itself.
#[pyclass(frozen, get_all, module = "armbridge")]
#[derive(Debug)]
pub(crate) struct Status {
    /// Mode: `idle`, `armed`, `regulate`, `track`, `fault` and so on; None before the first tick.
    mode: Option<String>,
    /// Name of the fault, in mode `fault`.
    fault: Option<String>,
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
        let mode = status.mode();
        let [first, second] = status.temperature;
        let output = status.record.map(|record| record.output);
        Self {
            mode: mode.map(|mode| match mode {
                Mode::Fault(_) => "fault".to_owned(),
                mode => enum_names::mode(mode).to_owned(),
            }),
            fault: mode
                .and_then(enum_names::fault_of)
                .map(|fault| fault.name().to_owned()),
            cause: status
                .trip
                .as_ref()
                .map(|trip| fault_text::in_words(trip).to_string()),
            obstacle: status.obstacle.map(|obstacle| obstacle.to_string()),
            is_armed: mode.is_some_and(Mode::is_armed),
            servos: status.servos.map(|servos| servos.firmware.to_string()),
            angle_rad: output.map(|output| output.angle_rad.into()),
            speed_rad_s: output.map(|output| output.speed_rad_s.into()),
            tick: status.record.map(|record| record.tick),
            temperature: (first, second),
        }
    }
}

#[pymethods]
impl Status {
    fn __repr__(&self) -> String {
        let mode = self.mode.as_deref().unwrap_or("unknown");
        // Writing to a string cannot fail.
        let mut text = format!("<Status mode={mode}");
        if let Some((first, second)) = self.angle_rad {
            let _ = write!(text, " angle_rad=({first:.3}, {second:.3})");
        }
        for (name, value) in [
            ("fault", &self.fault),
            ("cause", &self.cause),
            ("obstacle", &self.obstacle),
        ] {
            if let Some(value) = value {
                let _ = write!(text, " {name}={value:?}");
            }
        }
        text + ">"
    }
}
