//! Summary of a board's status in names, sentences and numbers, for programs in other languages.

use armbridge_link::message::Mode;
use armbridge_servo::JOINTS;
use serde::Serialize;

use crate::status::BoardStatus;
use crate::{enum_names, fault_text};

/// Summary of a [`BoardStatus`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatusSummary {
    /// Mode: `idle`, `armed`, `regulate`, `track`, `fault` and so on; none before the first tick.
    pub mode: Option<&'static str>,
    /// Name of the fault, in mode `fault`.
    pub fault: Option<&'static str>,
    /// Cause of the fault and what to do, in a sentence.
    pub cause: Option<String>,
    /// What the board lacks to be armed, in a sentence.
    pub obstacle: Option<String>,
    /// Whether the motors may be driven.
    pub is_armed: bool,
    /// Firmware of the servos, `Morpheus` or `stock`; none until they are found.
    pub servos: Option<String>,
    /// Estimated angles in rad.
    pub angle_rad: Option<[f32; JOINTS]>,
    /// Estimated speeds in rad/s.
    pub speed_rad_s: Option<[f32; JOINTS]>,
    /// Number of the latest tick.
    pub tick: Option<u32>,
    /// Temperatures of the servos: degrees Celsius of stock ones, converter counts of Morpheus.
    pub temperature: [Option<u16>; JOINTS],
}

impl From<&BoardStatus> for StatusSummary {
    fn from(status: &BoardStatus) -> Self {
        let mode = status.mode();
        let output = status.record.map(|record| record.output);
        let trip = status.trip.as_ref();
        Self {
            mode: mode.map(|mode| match mode {
                Mode::Fault(_) => "fault",
                mode => enum_names::mode(mode),
            }),
            fault: mode
                .and_then(enum_names::fault_of)
                .map(armbridge_link::message::Fault::name),
            cause: trip.map(|trip| fault_text::in_words(trip).to_string()),
            obstacle: status.obstacle.map(|obstacle| obstacle.to_string()),
            is_armed: mode.is_some_and(Mode::is_armed),
            servos: status.servos.map(|servos| servos.firmware.to_string()),
            angle_rad: output.map(|output| output.angle_rad),
            speed_rad_s: output.map(|output| output.speed_rad_s),
            tick: status.record.map(|record| record.tick),
            temperature: status.temperature,
        }
    }
}
