//! Kinds of servos on the bench.

use std::fmt;

use armbridge_client::servo_table::Table;
use armbridge_servo::protocol2::model::{self, Model};
use armbridge_servo::{Firmware, ServoId};

use super::half_duplex_bus::Device;
use super::morpheus_servo::{DEFAULT_ROM, Servo};
use super::stock_servo::Ax12a;
use super::x_servo::XServo;

/// The firmware of this name on the command line.
///
/// # Errors
/// If there is none.
pub fn firmware(name: &str) -> Result<Firmware, KindError> {
    match name {
        "morpheus" => Ok(Firmware::Morpheus),
        "stock" => Ok(Firmware::Stock),
        "x" => Ok(Firmware::XSeries),
        _ => Err(KindError::Firmware),
    }
}

/// A servo for the bench: these properties, and factory settings otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoKind {
    firmware: Firmware,
    id: u8,
    baud_register: u8,
}

impl fmt::Display for ServoKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let baud = match self.firmware {
            Firmware::Morpheus | Firmware::Stock => 2_000_000 / (u32::from(self.baud_register) + 1),
            Firmware::XSeries => model::baud_rate(self.baud_register).unwrap_or_default(),
        };
        write!(f, "{} ({}, {baud} baud)", self.id, self.firmware)
    }
}

/// Reason for which there is no such servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KindError {
    /// No firmware of this name.
    #[error("expected morpheus, stock or x")]
    Firmware,
    /// The id is out of range.
    #[error("a {firmware} servo cannot have id {id}: expected {lowest} to {highest}")]
    Id {
        /// Firmware.
        firmware: Firmware,
        /// Requested id.
        id: u8,
        /// Smallest id.
        lowest: u32,
        /// Largest id.
        highest: u32,
    },
    /// It has no such rate.
    #[error("a {firmware} servo has no rate of {baud} baud: {rates}")]
    Baud {
        /// Firmware.
        firmware: Firmware,
        /// Requested rate.
        baud: u32,
        /// Rates that it has.
        rates: &'static str,
    },
}

/// Rates of Morpheus, with their registers.
const MORPHEUS_RATES: [(u32, u8); 6] = [
    (2_000_000, 0),
    (1_000_000, 1),
    (500_000, 3),
    (115_200, 16),
    (57_600, 34),
    (9_600, 207),
];
/// Largest deviation of a stock servo's rate from the requested one: 115200 baud is
/// 2.1 % off.
const RATE_TOLERANCE: f64 = 0.025;

impl ServoKind {
    /// A servo with this firmware, id and rate.
    ///
    /// # Errors
    /// If the id or the rate is not possible.
    pub fn new(firmware: Firmware, id: u8, baud: u32) -> Result<Self, KindError> {
        let range = &Table::for_firmware(firmware)
            .by_name("id")
            .map(|id| id.range.clone());
        if let Some(range) = range
            && !range.contains(&id.into())
        {
            return Err(KindError::Id {
                firmware,
                id,
                lowest: *range.start(),
                highest: *range.end(),
            });
        }
        let baud_register = baud_register(firmware, baud)?;
        Ok(Self {
            firmware,
            id,
            baud_register,
        })
    }

    /// A servo with this firmware and id, and the rate of the board's first search.
    pub(super) fn at_one_megabaud(firmware: Firmware, id: ServoId) -> Self {
        Self {
            firmware,
            id: id.get(),
            baud_register: match firmware {
                Firmware::Morpheus | Firmware::Stock => 1,
                Firmware::XSeries => 3,
            },
        }
    }

    /// The servo; one of the X series is of this model.
    pub(super) fn build(self, x_model: &'static Model) -> Device {
        match self.firmware {
            Firmware::Morpheus => {
                let mut rom = DEFAULT_ROM;
                rom[0x01] = self.id;
                rom[0x0A] = self.baud_register;
                Servo::new(rom).into()
            }
            Firmware::Stock => Ax12a::new(self.id, self.baud_register).into(),
            Firmware::XSeries => XServo::new(x_model, self.id, self.baud_register).into(),
        }
    }
}

/// Value of a servo's baud register for this rate.
fn baud_register(firmware: Firmware, baud: u32) -> Result<u8, KindError> {
    let refused = |rates| KindError::Baud {
        firmware,
        baud,
        rates,
    };
    match firmware {
        Firmware::Morpheus => {
            let rate = MORPHEUS_RATES.iter().find(|(rate, _)| *rate == baud);
            rate.map(|(_, register)| *register)
                .ok_or_else(|| refused("expected 2000000, 1000000, 500000, 115200, 57600 or 9600"))
        }
        Firmware::Stock => {
            let exact = 2e6 / f64::from(baud.max(1)) - 1.0;
            let register = exact.round().clamp(0.0, 254.0);
            let error = 2e6 / (register + 1.0) / f64::from(baud.max(1)) - 1.0;
            if error.abs() > RATE_TOLERANCE {
                return Err(refused("expected 2000000 divided by 1 to 255"));
            }
            Ok(register as u8)
        }
        Firmware::XSeries => {
            let code = model::BAUD_RATES.iter().position(|rate| *rate == baud);
            code.map(|code| code as u8).ok_or_else(|| {
                refused(
                    "expected 9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000 or 4500000",
                )
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_board::bridge::SERVO_IDS;

    #[test]
    fn registers_of_the_rates_are_those_of_the_documents() {
        for (baud, register) in [
            (1_000_000, 1),
            (500_000, 3),
            (400_000, 4),
            (250_000, 7),
            (200_000, 9),
            (115_200, 16),
            (57_600, 34),
            (19_200, 103),
            (9_600, 207),
        ] {
            assert_eq!(baud_register(Firmware::Stock, baud), Ok(register), "{baud}");
        }
        for firmware in [Firmware::Morpheus, Firmware::Stock, Firmware::XSeries] {
            let [id, _] = SERVO_IDS;
            assert_eq!(
                ServoKind::new(firmware, id.get(), 1_000_000),
                Ok(ServoKind::at_one_megabaud(firmware, id))
            );
        }
        for (baud, register) in MORPHEUS_RATES {
            assert_eq!(baud_register(Firmware::Morpheus, baud), Ok(register));
        }
    }

    #[test]
    fn impossible_servos_are_refused_with_the_possible_values() {
        let refusal = |firmware, id, baud| {
            ServoKind::new(firmware, id, baud)
                .map_err(|error| error.to_string())
                .unwrap_err()
        };
        assert!(refusal(Firmware::Morpheus, 0, 1_000_000).contains("1 to 253"));
        assert!(refusal(Firmware::Stock, 254, 1_000_000).contains("0 to 253"));
        assert!(refusal(Firmware::Morpheus, 1, 250_000).contains("115200"));
        assert!(refusal(Firmware::Stock, 1, 750_000).contains("divided"));
        assert!(ServoKind::new(Firmware::Stock, 0, 250_000).is_ok());
        assert_eq!(firmware("xl"), Err(KindError::Firmware));
    }
}
