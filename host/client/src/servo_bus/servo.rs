//! One servo, its registers by name, with either firmware.
//!
//! Written values are read back and compared: a Morpheus servo answers OK to
//! values that it ignores, and a stock servo may be configured not to answer.
//! Three registers of Morpheus cannot be compared, or not wholly:
//!
//! |            | written               | read                                    |
//! |------------|-----------------------|-----------------------------------------|
//! | `position` | the goal              | present position, from START and CYCLE  |
//! | `speed`    | of the motion, 1..=10 | present speed, without sign             |
//! | `pwm`      | the PWM               | its low byte; the high byte is always 0 |

use armbridge_servo::{Alarms, Firmware};

use super::diagnosis::Diagnosis;
use super::line::Line;
use super::master::{BusError, BusMaster};
use super::reading::{Closed, Reading, ServoError, Taken, Value};
use super::request::Request;
use crate::servo_table::{Access, Register, Storage, Table};

/// Highest id that START waits for, unless ours is higher.
const START_ID_MAX: u8 = 32;
/// Attempts to find a servo that has not answered.
const ATTEMPTS: usize = 3;

/// A servo that has answered.
#[derive(Debug)]
pub struct Servo<'a, L> {
    pub(super) client: &'a mut BusMaster<L>,
    pub(super) id: u8,
    firmware: Firmware,
    alarms: Alarms,
}

impl<'a, L: Line> Servo<'a, L> {
    /// The servo with this id, pinged in both protocols.
    ///
    /// # Errors
    /// If none answers, or two.
    pub fn find(client: &'a mut BusMaster<L>, id: u8) -> Result<Self, ServoError> {
        let failed = |error| ServoError::Bus { id, error };
        let mut found = None;
        for _ in 0..ATTEMPTS {
            for firmware in Firmware::ALL {
                let Some(alarms) = client.ping(firmware, id).map_err(failed)? else {
                    continue;
                };
                if found.replace((firmware, alarms)).is_some() {
                    return Err(ServoError::TwoFirmwares(id));
                }
            }
            if found.is_some() {
                break;
            }
        }
        let silence = Diagnosis::silence(client.echoes());
        let (firmware, alarms) = found.ok_or_else(|| failed(silence.into()))?;
        Ok(Self::known(client, id, firmware, alarms))
    }

    /// A servo that has just answered a ping.
    pub(super) fn known(
        client: &'a mut BusMaster<L>,
        id: u8,
        firmware: Firmware,
        alarms: Alarms,
    ) -> Self {
        Self {
            client,
            id,
            firmware,
            alarms,
        }
    }

    /// Its id.
    pub fn id(&self) -> u8 {
        self.id
    }

    /// Its firmware.
    pub fn firmware(&self) -> Firmware {
        self.firmware
    }

    /// Its alarms when it was found.
    pub fn alarms(&self) -> Alarms {
        self.alarms
    }

    /// Reads one register.
    ///
    /// # Errors
    /// If there is no valid reply.
    pub fn read(&mut self, register: &'static Register) -> Result<Reading, ServoError> {
        if self.is_position(register) {
            return self.position(register);
        }
        let bytes = self.bytes(register.address, register.size.bytes())?;
        Ok(self.reading(register, &bytes, register.address))
    }

    /// Reads one register after the other, and leaves out what the servo refuses.
    fn read_each(&mut self, table: &'static Table) -> Result<Vec<Reading>, ServoError> {
        let readings = table.registers.iter().map(|register| self.read(register));
        readings
            .filter(|reading| {
                !matches!(
                    reading,
                    Err(ServoError::Bus {
                        error: BusError::Diagnosis(Diagnosis::Refused(_)),
                        ..
                    })
                )
            })
            .collect()
    }

    /// Reads all registers.
    ///
    /// # Errors
    /// If there is no valid reply.
    pub fn read_all(&mut self) -> Result<Vec<Reading>, ServoError> {
        let table = Table::for_firmware(self.firmware);
        // Ranges of one READ each: first address and length. A Morpheus servo's position
        // is between them.
        let spans: &[(u16, u16)] = match self.firmware {
            Firmware::Morpheus => &[(0x00, 11), (0x0C, 6)],
            Firmware::Stock => &[(0, table.size)],
            // There are gaps, and models lack some of the registers.
            Firmware::XSeries => return self.read_each(table),
        };
        let mut memory = vec![0; table.size.into()];
        for &(from, count) in spans {
            match self.bytes(from, count) {
                Ok(bytes) => memory[from.into()..][..bytes.len()].copy_from_slice(&bytes),
                // The board rejects requests whose reply does not fit into its tick.
                Err(ServoError::Bus {
                    error: BusError::Diagnosis(Diagnosis::Refused(_)),
                    ..
                }) => {
                    return table
                        .registers
                        .iter()
                        .map(|register| self.read(register))
                        .collect();
                }
                Err(error) => return Err(error),
            }
        }
        table
            .registers
            .iter()
            .map(|register| {
                if self.is_position(register) {
                    self.position(register)
                } else {
                    Ok(self.reading(register, &memory, 0))
                }
            })
            .collect()
    }

    /// Checks a value against the register's access and range.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn check(&self, register: &Register, value: u32) -> Result<(), ServoError> {
        let name = register.name;
        if register.access == Access::Read {
            return Err(ServoError::ReadOnly { name });
        }
        let command = match name {
            "id" => Some("set-id"),
            "baud_rate" => Some("set-baud"),
            _ => None,
        };
        if let Some(command) = command {
            return Err(ServoError::OtherCommand { name, command });
        }
        let range = match (self.firmware, name) {
            // Reads return any speed, but writes accept at most 10.
            (Firmware::Morpheus, "speed") => 0..=10,
            _ => register.range.clone(),
        };
        if !range.contains(&value) {
            return Err(ServoError::OutOfRange { name, value, range });
        }
        Ok(())
    }

    /// Writes one register and reads it back.
    ///
    /// # Errors
    /// If it cannot be written, or the servo has not stored the value.
    pub fn write(&mut self, register: &'static Register, value: u32) -> Result<Taken, ServoError> {
        self.check(register, value)?;
        if self.is_position(register) {
            self.check_margins(register, value)?;
        }
        self.send_write(register, value)?;
        if self.firmware == Firmware::Morpheus && matches!(register.name, "position" | "speed") {
            return Ok(Taken::NotReadable);
        }
        self.expect(register, value)
    }

    /// Writes a register. A missing reply is no error: reading back decides.
    pub(super) fn send_write(
        &mut self,
        register: &'static Register,
        value: u32,
    ) -> Result<(), ServoError> {
        let request = Request::write(self.firmware, self.id, register, value);
        let result = self.send(request);
        if result.is_err() {
            self.check_open(register)?;
        }
        result
    }

    /// Sends a request that may have no reply.
    pub(super) fn send(&mut self, request: Option<Request>) -> Result<(), ServoError> {
        let request = request.ok_or_else(|| self.failed(BusError::NoRequest))?;
        match self.client.ask(&request) {
            Err(BusError::Diagnosis(diagnosis)) if !matches!(diagnosis, Diagnosis::Refused(_)) => {
                Ok(())
            }
            Err(error) => Err(self.failed(error)),
            Ok(_) => Ok(()),
        }
    }

    /// Reads a register whose value should be `wanted`.
    pub(super) fn expect(
        &mut self,
        register: &'static Register,
        wanted: u32,
    ) -> Result<Taken, ServoError> {
        let (id, name) = (self.id, register.name);
        let read = self
            .read(register)
            .map_err(|error| ServoError::NotReadBack {
                id,
                name,
                error: error.into(),
            })?;
        let (stored, taken) = match read.value {
            Value::Known(stored) => (stored, Taken::ReadBack),
            Value::LowByte(low) => {
                // The value if the high byte is the wanted one.
                (wanted & 0xFF00 | u32::from(low), Taken::LowByteReadBack)
            }
        };
        if stored == wanted {
            return Ok(taken);
        }
        self.check_open(register)?;
        Err(ServoError::StoredOther {
            id,
            name,
            wanted,
            stored,
        })
    }

    /// Checks that the EEPROM is open, if the register is there.
    fn check_open(&mut self, register: &Register) -> Result<(), ServoError> {
        if register.storage == Storage::Ram {
            return Ok(());
        }
        let (id, name) = (self.id, register.name);
        for (closing, why) in [("torque_enable", Closed::Torque), ("lock", Closed::Lock)] {
            let closing = Table::for_firmware(self.firmware).by_name(closing);
            let read = closing.and_then(|closing| self.read(closing).ok());
            if read.is_some_and(|read| read.value == Value::Known(1)) {
                return Err(ServoError::Closed { id, name, why });
            }
        }
        Ok(())
    }

    /// Whether it is a Morpheus servo's position, which READ cannot access.
    fn is_position(&self, register: &Register) -> bool {
        self.firmware == Firmware::Morpheus && register.name == "position"
    }

    fn position(&mut self, register: &'static Register) -> Result<Reading, ServoError> {
        let id = self.id;
        let failed = |error: std::io::Error| ServoError::Bus {
            id,
            error: error.into(),
        };
        for is_started in [false, true, true] {
            let positions = self.client.cycle().map_err(failed)?;
            if let Some((_, counts)) = positions.iter().find(|(from, _)| *from == id) {
                return Ok(Reading {
                    register,
                    value: Value::Known((*counts).into()),
                });
            }
            if !is_started {
                self.client.start(id.max(START_ID_MAX)).map_err(failed)?;
            }
        }
        Err(self.failed(Diagnosis::Silence.into()))
    }

    /// Checks a goal against the margins: Morpheus answers OK to a goal outside, ignores it,
    /// and resets its PWM.
    fn check_margins(&mut self, register: &Register, goal: u32) -> Result<(), ServoError> {
        let margins = self.bytes(0x02, 2)?;
        let [upper, lower] = [0, 1].map(|i| margins.get(i).copied().unwrap_or_default());
        let range = u32::from(lower)..=1023 - u32::from(upper);
        if range.contains(&goal) {
            return Ok(());
        }
        Err(ServoError::OutOfRange {
            name: register.name,
            value: goal,
            range,
        })
    }

    fn bytes(&mut self, address: u16, count: u16) -> Result<Vec<u8>, ServoError> {
        let request = Request::read(self.firmware, self.id, address, count);
        let request = request.ok_or_else(|| self.failed(BusError::NoRequest))?;
        match self.client.request_with_retries(&request) {
            Ok(packet) if packet.data.len() == usize::from(count) => Ok(packet.data),
            Ok(_) => Err(self.failed(Diagnosis::UnexpectedContent { id: self.id }.into())),
            Err(BusError::Diagnosis(Diagnosis::Silence | Diagnosis::EchoOnly))
                if self.firmware == Firmware::Stock && self.answers_ping() =>
            {
                Err(ServoError::Mute(self.id))
            }
            Err(error) => Err(self.failed(error)),
        }
    }

    fn answers_ping(&mut self) -> bool {
        matches!(self.client.ping(self.firmware, self.id), Ok(Some(_)))
    }

    fn reading(&self, register: &'static Register, bytes: &[u8], from: u16) -> Reading {
        let value = register.value_in(bytes, from).unwrap_or_default();
        let is_low_byte = self.firmware == Firmware::Morpheus && register.name == "pwm";
        Reading {
            register,
            value: if is_low_byte {
                Value::LowByte(value as u8)
            } else {
                Value::Known(value)
            },
        }
    }

    pub(super) fn failed(&self, error: BusError) -> ServoError {
        ServoError::Bus { id: self.id, error }
    }
}
