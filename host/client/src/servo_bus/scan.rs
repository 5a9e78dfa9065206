//! Search for servos: every id, in both protocols, at several baud rates.
//!
//! At each rate all Morpheus pings come before all Protocol 1.0 pings, and no
//! ping is a broadcast, which all Morpheus servos answer at once. An id
//! without a servo costs the timeout twice: 40 ms.

use std::io;
use std::ops::RangeInclusive;

use armbridge_servo::{Alarms, Firmware};

use super::line::Line;
use super::master::{BusError, BusMaster};
use super::reading::{ServoError, Value};
use super::servo::Servo;
use crate::servo_table::Table;

/// Range of a search.
#[derive(Clone, Debug)]
pub struct Area {
    /// Ids.
    pub ids: RangeInclusive<u8>,
    /// Rates; ignored where the rate cannot be set.
    pub bauds: Vec<u32>,
}

/// A servo that answered its ping.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Its rate, where that can be set.
    pub baud: Option<u32>,
    /// Its id.
    pub id: u8,
    /// Its firmware.
    pub firmware: Firmware,
    /// Its alarms; Morpheus has none.
    pub alarms: Alarms,
    /// Further information, if it can be read.
    pub details: Details,
}

/// Information in a servo's registers. Morpheus has its temperature only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Details {
    /// Model number.
    pub model: Option<u32>,
    /// Version of the firmware.
    pub version: Option<u32>,
    /// In °C, or, for Morpheus, in counts of its converter.
    pub temperature: Option<u32>,
    /// Supply in 0.1 V.
    pub decivolt: Option<u32>,
}

/// An id with an invalid reply, or a servo that
/// answers its ping and cannot be read.
#[derive(Debug)]
pub struct ScanError {
    /// Its rate, where that can be set.
    pub baud: Option<u32>,
    /// Its id.
    pub id: u8,
    /// Firmware of the request.
    pub firmware: Firmware,
    /// Error of the exchange.
    pub diagnosis: String,
}

/// Result of a search.
#[derive(Debug, Default)]
pub struct Report {
    /// Servos.
    pub found: Vec<Found>,
    /// Ids that may be servos.
    pub troubles: Vec<ScanError>,
    /// Whether the line echoes.
    pub echoes: bool,
}

impl Report {
    /// Whether servos of several firmwares were found, which the board refuses.
    pub fn is_mixed(&self) -> bool {
        let mut neighbours = self.found.windows(2);
        neighbours.any(|two| matches!(two, [a, b] if a.firmware != b.firmware))
    }
}

/// Progress of a search.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Pings so far.
    pub done: usize,
    /// Pings in all.
    pub total: usize,
    /// Present rate, where that can be set.
    pub baud: Option<u32>,
    /// Present id.
    pub id: u8,
}

/// Searches for servos and reads their information. The line returns to the
/// rate at which it began.
///
/// # Errors
/// If the stream fails, or does not support a rate.
pub fn scan<L: Line>(
    client: &mut BusMaster<L>,
    area: &Area,
    mut progress: impl FnMut(Step),
) -> io::Result<Report> {
    let first = client.baud();
    let bauds: &[u32] = match first {
        Some(_) => &area.bauds,
        // The rate has no effect.
        None => &[0],
    };
    let mut report = Report::default();
    let total = bauds.len() * area.ids.len() * Firmware::ALL.len();
    let mut done = 0;
    for baud in bauds {
        client.set_baud(*baud).map_err(|error| {
            let text = format!("{baud} baud: {error}");
            io::Error::new(error.kind(), text)
        })?;
        for firmware in Firmware::ALL {
            for id in area.ids.clone() {
                let baud = client.baud();
                progress(Step {
                    done,
                    total,
                    baud,
                    id,
                });
                probe(client, firmware, id, &mut report)?;
                done += 1;
            }
        }
    }
    if let Some(first) = first {
        client.set_baud(first)?;
    }
    report.echoes = client.echoes();
    report.found.sort_by_key(|found| found.id);
    Ok(report)
}

/// Pings one id in one protocol.
fn probe<L: Line>(
    client: &mut BusMaster<L>,
    firmware: Firmware,
    id: u8,
    report: &mut Report,
) -> io::Result<()> {
    let baud = client.baud();
    let mut push_error = |diagnosis| {
        report.troubles.push(ScanError {
            baud,
            id,
            firmware,
            diagnosis,
        });
    };
    let alarms = match client.ping(firmware, id) {
        Ok(Some(alarms)) => alarms,
        Ok(None) => return Ok(()),
        Err(BusError::Line(error)) => return Err(error),
        Err(error) => {
            push_error(error.to_string());
            return Ok(());
        }
    };
    let mut servo = Servo::known(client, id, firmware, alarms);
    let details = match details(&mut servo) {
        Ok(details) => details,
        Err(ServoError::Bus {
            error: BusError::Line(error),
            ..
        }) => return Err(error),
        Err(error) => {
            push_error(error.to_string());
            Details::default()
        }
    };
    report.found.push(Found {
        baud,
        id,
        firmware,
        alarms,
        details,
    });
    Ok(())
}

/// Information of a servo. A stock servo is read completely: two with one id may answer
/// PING like one, but rarely have the same position.
fn details<L: Line>(servo: &mut Servo<L>) -> Result<Details, ServoError> {
    let readings = match servo.firmware() {
        Firmware::Morpheus => {
            let temperature = Table::for_firmware(Firmware::Morpheus).by_name("temperature");
            let reading = temperature.map(|register| servo.read(register));
            reading.into_iter().collect::<Result<_, _>>()?
        }
        Firmware::Stock | Firmware::XSeries => servo.read_all()?,
    };
    let number = |name| {
        let reading = readings
            .iter()
            .find(|reading| reading.register.name == name);
        reading.and_then(|reading| match reading.value {
            Value::Known(value) => Some(value),
            Value::LowByte(_) => None,
        })
    };
    Ok(Details {
        model: number("model_number"),
        version: number("firmware_version"),
        temperature: number("present_temperature").or(number("temperature")),
        decivolt: number("present_voltage").or(number("present_input_voltage")),
    })
}
