//! Who is on the bus: every id, in both protocols, at several baud rates.
//!
//! At each rate all Morpheus pings come before all Protocol 1.0 pings, and no
//! ping is a broadcast, to which Morpheus servos answer all at once. An id at
//! which nobody is costs the client's patience, twice: 40 ms.

use std::io;
use std::ops::RangeInclusive;

use armbridge_shared::servo::Firmware;
use armbridge_shared::servo::protocol1::Alarms;

use super::line::Line;
use super::master::{BusError, BusMaster};
use super::reading::{ServoError, Value};
use super::servo::Servo;
use crate::servo_table::Table;

/// Where to look.
#[derive(Clone, Debug)]
pub struct Area {
    /// At which ids.
    pub ids: RangeInclusive<u8>,
    /// At which rates; ignored where the rate cannot be set.
    pub bauds: Vec<u32>,
}

/// A servo that answered its ping.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// At which rate, where that can be set.
    pub baud: Option<u32>,
    /// Its id.
    pub id: u8,
    /// What it runs.
    pub firmware: Firmware,
    /// What it complains of; Morpheus never does.
    pub alarms: Alarms,
    /// What it says of itself, if it can be read.
    pub details: Details,
}

/// What a servo says of itself. Morpheus knows its temperature, no more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Details {
    /// Model number.
    pub model: Option<u16>,
    /// Version of the firmware.
    pub version: Option<u16>,
    /// In °C, or, of Morpheus, in counts of its converter.
    pub temperature: Option<u16>,
    /// Supply in 0.1 V.
    pub decivolt: Option<u16>,
}

/// An id from which something else than an answer was heard, or a servo that
/// answers its ping and cannot be read.
#[derive(Debug)]
pub struct Trouble {
    /// At which rate, where that can be set.
    pub baud: Option<u32>,
    /// With which id.
    pub id: u8,
    /// Asked in whose words.
    pub firmware: Firmware,
    /// What it was.
    pub diagnosis: String,
}

/// What a scan has found.
#[derive(Debug, Default)]
pub struct Report {
    /// Servos.
    pub found: Vec<Found>,
    /// And what may be servos.
    pub troubles: Vec<Trouble>,
    /// Whether the line hears itself.
    pub echoes: bool,
}

impl Report {
    /// Whether both firmwares are there, which the board refuses.
    pub fn is_mixed(&self) -> bool {
        let has = |firmware| self.found.iter().any(|found| found.firmware == firmware);
        Firmware::ALL.into_iter().all(has)
    }
}

/// How far a scan is.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Pings so far.
    pub done: usize,
    /// Pings in all.
    pub total: usize,
    /// The rate now, where that can be set.
    pub baud: Option<u32>,
    /// The id now.
    pub id: u8,
}

/// Looks for servos and reads what they say of themselves. The line ends at the
/// rate at which it began.
///
/// # Errors
/// If the stream fails, or does not know a rate.
pub fn scan<L: Line>(
    client: &mut BusMaster<L>,
    area: &Area,
    mut progress: impl FnMut(Step),
) -> io::Result<Report> {
    let first = client.baud();
    let bauds: &[u32] = match first {
        Some(_) => &area.bauds,
        // Whatever it is.
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
                look(client, firmware, id, &mut report)?;
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
fn look<L: Line>(
    client: &mut BusMaster<L>,
    firmware: Firmware,
    id: u8,
    report: &mut Report,
) -> io::Result<()> {
    let baud = client.baud();
    let mut trouble = |diagnosis| {
        report.troubles.push(Trouble {
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
            trouble(error.to_string());
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
            trouble(error.to_string());
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

/// A stock servo is read as a whole: two of them with one id may answer PING
/// like one, but hardly ever hold the same position.
fn details<L: Line>(servo: &mut Servo<L>) -> Result<Details, ServoError> {
    let readings = match servo.firmware() {
        Firmware::Morpheus => {
            let temperature = Table::for_firmware(Firmware::Morpheus).by_name("temperature");
            let reading = temperature.map(|register| servo.read(register));
            reading.into_iter().collect::<Result<_, _>>()?
        }
        Firmware::Stock => servo.read_all()?,
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
        decivolt: number("present_voltage"),
    })
}
