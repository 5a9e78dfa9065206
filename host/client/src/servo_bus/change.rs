//! Changes of a servo's id, baud rate, and all settings at once.
//!
//! Each is checked before, so that no two servos get one id, and read back afterwards. A Morpheus servo answers these with its new id or at its new
//! rate, and receives nothing meanwhile for 8.5 ms a byte, or 0.1 s for all of them.

use armbridge_servo::Firmware;

use super::diagnosis::Diagnosis;
use super::line::Line;
use super::master::BusError;
use super::reading::{Reading, ServoError, Taken, Value};
use super::request::Request;
use super::servo::Servo;
use crate::servo_table::{Register, Storage, Table};
use armbridge_servo::protocol2::model;
use std::time::Duration;

/// Id after a factory reset, of any firmware.
const FACTORY_ID: u8 = 1;
/// Time in which an X servo restarts after a factory reset: assumed, since the e-Manual has none.
const RESTART: Duration = Duration::from_millis(500);

/// Reason for which a change was not made, or is uncertain.
#[derive(Debug, thiserror::Error)]
pub enum ChangeError {
    /// No servo can have this id.
    #[error("an id is from {} to 253, not {id}", lowest(*.firmware))]
    Id {
        /// Requested id.
        id: u8,
        /// Firmware of the servo.
        firmware: Firmware,
    },
    /// Another servo has this id.
    #[error("id {id} is taken: {reply_text}; two servos with one id cannot be told apart")]
    Occupied {
        /// Requested id.
        id: u8,
        /// Text about its reply.
        reply_text: String,
    },
    /// The servo has no such rate.
    #[error("{firmware} servos do not run at {baud} baud, but at {}", rates(*.firmware))]
    Baud {
        /// Firmware of the servo.
        baud: u32,
        /// Requested rate.
        firmware: Firmware,
    },
    /// The line's rate cannot be changed from here.
    #[error(
        "the rate of a TCP stream cannot be followed from here, so the servo would be lost \
         until the other side is set to {baud} baud; --blind changes it all the same"
    )]
    RateFixed {
        /// Requested rate.
        baud: u32,
    },
    /// The servo is lost.
    #[error("the servo answers neither {new} nor {old}: {error}; `armbridge scan` may find it")]
    Lost {
        /// Expected id or rate.
        new: String,
        /// Previous id or rate.
        old: String,
        /// Error with the new id or rate.
        error: ServoError,
    },
    /// Nothing has changed.
    #[error("the servo still answers {old}: it did not take the change")]
    Unchanged {
        /// Id or rate.
        old: String,
    },
    /// Some settings are not the factory ones.
    #[error("after the reset servo 1 does not hold the factory settings: {}", list(.0))]
    NotReset(Vec<Reading>),
    /// Error of a register access.
    #[error(transparent)]
    Servo(#[from] ServoError),
}

impl ChangeError {
    /// As [`ServoError::is_servo_error`].
    pub fn is_servo_error(&self) -> bool {
        match self {
            Self::Servo(error) | Self::Lost { error, .. } => error.is_servo_error(),
            Self::Occupied { .. } | Self::Unchanged { .. } | Self::NotReset(_) => true,
            Self::Id { .. } | Self::Baud { .. } | Self::RateFixed { .. } => false,
        }
    }
}

fn lowest(firmware: Firmware) -> u8 {
    u8::from(!firmware.has_id(0))
}

fn rates(firmware: Firmware) -> String {
    let rates: Vec<String> = baud_codes(firmware)
        .iter()
        .map(|(_, baud)| baud.to_string())
        .collect();
    rates.join(", ")
}

fn list(readings: &[Reading]) -> String {
    let one = |reading: &Reading| match reading.value {
        Value::Known(value) => format!("{} is {value}", reading.register.name),
        Value::LowByte(_) => reading.register.name.to_owned(),
    };
    let all: Vec<String> = readings.iter().map(one).collect();
    all.join(", ")
}

/// Values of the baud register, and the rates of the manual.
///
/// A servo runs at 2 000 000 / (value + 1): a difference of 2 % is tolerated. Of
/// the stock servo's rates, those in its manual; Morpheus accepts no others,
/// and 2 Mbaud, at which it overruns on every packet.
fn baud_codes(firmware: Firmware) -> Vec<(u32, u32)> {
    const STOCK: [(u32, u32); 9] = [
        (1, 1_000_000),
        (3, 500_000),
        (4, 400_000),
        (7, 250_000),
        (9, 200_000),
        (16, 115_200),
        (34, 57_600),
        (103, 19_200),
        (207, 9_600),
    ];
    const MORPHEUS: [(u32, u32); 5] = [
        (1, 1_000_000),
        (3, 500_000),
        (16, 115_200),
        (34, 57_600),
        (207, 9_600),
    ];
    match firmware {
        Firmware::Morpheus => MORPHEUS.to_vec(),
        Firmware::Stock => STOCK.to_vec(),
        Firmware::XSeries => (0..).zip(model::BAUD_RATES).collect(),
    }
}

/// Baud rate after a factory reset.
const fn factory_baud(firmware: Firmware) -> u32 {
    match firmware {
        Firmware::Morpheus | Firmware::Stock => 1_000_000,
        Firmware::XSeries => 57_600,
    }
}

fn baud_code(firmware: Firmware, baud: u32) -> Result<u32, ChangeError> {
    baud_codes(firmware)
        .iter()
        .find(|(_, rate)| *rate == baud)
        .map(|(baud_code, _)| *baud_code)
        .ok_or(ChangeError::Baud { baud, firmware })
}

impl<L: Line> Servo<'_, L> {
    /// Changes its id, if no other servo has the new one.
    ///
    /// # Errors
    /// If the id is not available, or the servo does not answer with it.
    pub fn set_id(&mut self, new: u8) -> Result<(), ChangeError> {
        let (old, firmware) = (self.id, self.firmware());
        if !firmware.has_id(new) {
            return Err(ChangeError::Id { id: new, firmware });
        }
        let id = self.register("id")?;
        if new != old {
            self.check_free(new)?;
            self.send_write(id, new.into())?;
        }
        self.id = new;
        let Err(error) = self.expect(id, new.into()) else {
            return Ok(());
        };
        self.id = old;
        let name = |id| format!("as id {id}");
        Err(self.lost(name(new), name(old), error))
    }

    /// Changes its baud rate, and that of the line. `blind`: also
    /// where the line's rate cannot be changed, without reading it back.
    ///
    /// # Errors
    /// If it has no such rate, or does not answer at it.
    pub fn set_baud(&mut self, baud: u32, blind: bool) -> Result<Taken, ChangeError> {
        let baud_code = baud_code(self.firmware(), baud)?;
        let register = self.register("baud_rate")?;
        let Some(old) = self.client.baud() else {
            if !blind {
                return Err(ChangeError::RateFixed { baud });
            }
            self.send_write(register, baud_code)?;
            return Ok(Taken::NotReadable);
        };
        if baud != old {
            self.check_free_at(Some(baud), self.id)?;
            self.send_write(register, baud_code)?;
        }
        self.set_line_baud(baud)?;
        let error = match self.expect(register, baud_code) {
            Ok(taken) => return Ok(taken),
            Err(error) => error,
        };
        self.set_line_baud(old)?;
        let name = |baud| format!("at {baud} baud");
        Err(self.lost(name(baud), name(old), error))
    }

    /// Restores the factory settings, id 1 and the baud rate among them, and reads
    /// them back.
    ///
    /// # Errors
    /// If another servo has id 1, or this one does not answer there, or has
    /// other settings.
    pub fn factory_reset(&mut self) -> Result<(), ChangeError> {
        let factory_baud = factory_baud(self.firmware());
        let baud = self.client.baud().map(|_| factory_baud);
        if (self.id, self.client.baud()) != (FACTORY_ID, baud) {
            self.check_free_at(baud, FACTORY_ID)?;
        }
        let old = format!("as id {}", self.id);
        let request = Request::factory_reset(self.firmware(), self.id);
        self.send(request)?;
        if self.firmware() == Firmware::XSeries {
            std::thread::sleep(RESTART);
        }
        if let Some(baud) = baud {
            self.set_line_baud(baud)?;
        }
        self.id = FACTORY_ID;
        let settings = match self.read_all() {
            Ok(settings) => settings,
            Err(error) => {
                let new = format!("as id {FACTORY_ID}, at {factory_baud} baud");
                return Err(ChangeError::Lost { new, old, error });
            }
        };
        let is_other = |reading: &Reading| {
            let initial = reading.register.initial.map(Value::Known);
            reading.register.storage == Storage::Eeprom
                && initial.is_some_and(|initial| initial != reading.value)
        };
        let other: Vec<Reading> = settings.into_iter().filter(is_other).collect();
        if other.is_empty() {
            Ok(())
        } else {
            Err(ChangeError::NotReset(other))
        }
    }

    fn register(&self, name: &str) -> Result<&'static Register, ServoError> {
        let register = Table::for_firmware(self.firmware()).by_name(name);
        register.ok_or_else(|| self.failed(BusError::NoRequest))
    }

    /// Checks that no servo answers with this id, in either protocol, at the present rate.
    fn check_free(&mut self, id: u8) -> Result<(), ChangeError> {
        for firmware in Firmware::ALL {
            let reply_text = match self.client.ping(firmware, id) {
                Ok(None) => continue,
                Ok(Some(_)) => format!("{} answers", with_article(firmware)),
                Err(BusError::Diagnosis(diagnosis))
                    if !matches!(diagnosis, Diagnosis::Refused(_)) =>
                {
                    diagnosis.to_string()
                }
                Err(error) => return Err(self.failed(error).into()),
            };
            return Err(ChangeError::Occupied { id, reply_text });
        }
        Ok(())
    }

    /// The same at another rate, after which the line returns to the present one.
    fn check_free_at(&mut self, baud: Option<u32>, id: u8) -> Result<(), ChangeError> {
        let (Some(baud), Some(old)) = (baud, self.client.baud()) else {
            return self.check_free(id);
        };
        self.set_line_baud(baud)?;
        let free = self.check_free(id);
        self.set_line_baud(old)?;
        free
    }

    fn set_line_baud(&mut self, baud: u32) -> Result<(), ServoError> {
        match self.client.set_baud(baud) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.failed(error.into())),
        }
    }

    /// Error of a servo that did not answer at `new`: tries the old id or rate.
    fn lost(&mut self, new: String, old: String, error: ServoError) -> ChangeError {
        match self.client.ping(self.firmware(), self.id) {
            Ok(Some(_)) => ChangeError::Unchanged { old },
            _ => ChangeError::Lost { new, old, error },
        }
    }
}

fn with_article(firmware: Firmware) -> String {
    match firmware {
        Firmware::Morpheus => format!("a {firmware} servo"),
        Firmware::Stock => format!("an {firmware}"),
        Firmware::XSeries => format!("a servo of the {firmware}"),
    }
}
