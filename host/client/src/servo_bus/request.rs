//! Requests to one servo, in the protocol of its firmware.

use std::time::Duration;

use armbridge_servo::morpheus::safe_read::{self, Plan};
use armbridge_servo::morpheus::{Frame, MASTER, Request as Morpheus, ServoId, frame};
use armbridge_servo::protocol1::Instruction;
use armbridge_servo::protocol1::frame::FRAME_MAX;
use armbridge_servo::{Firmware, Pwm, protocol2};

use crate::servo_table::{Register, Storage};

/// Whether a servo may move after this write. Writes that stop it are excluded, so that
/// they need no confirmation.
pub fn moves(firmware: Firmware, register: &Register, value: u32) -> bool {
    let moving: &[&str] = match firmware {
        Firmware::Morpheus => &["position", "speed", "pwm"],
        // Both angle limits 0 are wheel mode, in which the moving speed is
        // the motor's duty; a speed of 0 is the highest in joint mode.
        Firmware::Stock => &[
            "cw_angle_limit",
            "ccw_angle_limit",
            "torque_enable",
            "goal_position",
            "moving_speed",
        ],
        Firmware::XSeries => &[
            "operating_mode",
            "torque_enable",
            "goal_pwm",
            "goal_current",
            "goal_velocity",
            "goal_position",
        ],
    };
    let stops = match register.name {
        "pwm" => value == u32::from(Pwm::OFF.counts()),
        "torque_enable" => value == 0,
        _ => false,
    };
    moving.contains(&register.name) && !stops
}

/// Morpheus command code that the board never sends.
const WRITE: u8 = 0x03;
/// Morpheus command code that the board never sends.
const RESET: u8 = 0x09;
/// Time of an EEPROM byte in the servo, 8.5 ms, and of a Morpheus servo that restores
/// all eleven, with a margin.
const EEPROM_BYTE: Duration = Duration::from_millis(10);
const EEPROM_ALL: Duration = Duration::from_millis(120);

/// Parameter of a factory reset of an X servo that keeps neither id nor baud rate.
const RESET_ALL: u8 = 0xFF;
/// Data of the longest reply to a ping: model number and version of an X servo.
const PONG_DATA: usize = 3;

/// A packet for one servo, and its expected reply.
#[derive(Clone, Debug)]
pub struct Request {
    /// Firmware.
    pub firmware: Firmware,
    /// Id of the servo.
    pub id: u8,
    /// Bytes on the wire.
    pub bytes: Vec<u8>,
    /// Longest payload of the reply.
    pub reply_data: usize,
    /// Longest time until the reply.
    pub execution_time: Duration,
    /// Requested part of a Morpheus reply, if it is a reading.
    plan: Option<Plan>,
}

impl Request {
    /// A ping; `None` if no servo with this firmware can have the id.
    pub fn ping(firmware: Firmware, id: u8) -> Option<Self> {
        let bytes = match firmware {
            Firmware::Morpheus => Morpheus::Ping(ServoId::new(id)?).encode().to_vec(),
            Firmware::Stock => stock(id, &Instruction::Ping)?,
            Firmware::XSeries => x_series(id, &protocol2::Instruction::Ping)?,
        };
        Some(Self::new(firmware, id, bytes, PONG_DATA))
    }

    /// Reads this many bytes. `None` where no servo has them, or there is no safe READ.
    pub fn read(firmware: Firmware, id: u8, address: u16, count: u16) -> Option<Self> {
        let plan = match firmware {
            Firmware::Morpheus => {
                let [address, count] = [address, count].map(u8::try_from);
                Some(safe_read::plan(address.ok()?, count.ok()?).ok()?)
            }
            Firmware::Stock | Firmware::XSeries => None,
        };
        let bytes = match (plan, firmware) {
            (Some(plan), _) => plan.request(ServoId::new(id)?).to_vec(),
            (None, Firmware::XSeries) => {
                x_series(id, &protocol2::Instruction::Read { address, count })?
            }
            (None, _) => stock(id, &Instruction::Read { address, count })?,
        };
        let longest = firmware.memory_bytes().into();
        let request = Self::new(firmware, id, bytes, longest);
        Some(Self { plan, ..request })
    }

    /// Writes a register. `None` if that cannot be encoded.
    pub fn write(firmware: Firmware, id: u8, register: &Register, value: u32) -> Option<Self> {
        let data = register.bytes_of(value);
        let address = register.address;
        let bytes = match firmware {
            Firmware::Morpheus => {
                let head = [WRITE, u8::try_from(address).ok()?];
                morpheus(id, &[&head, data.as_slice()].concat())?
            }
            Firmware::Stock => stock(
                id,
                &Instruction::Write {
                    address,
                    data: &data,
                },
            )?,
            Firmware::XSeries => x_series(
                id,
                &protocol2::Instruction::Write {
                    address,
                    data: &data,
                },
            )?,
        };
        let execution_time = match register.storage {
            Storage::Eeprom => EEPROM_BYTE * u32::from(register.size.bytes()),
            Storage::Ram => Duration::ZERO,
        };
        let request = Self::new(firmware, id, bytes, 1);
        Some(Self {
            execution_time,
            ..request
        })
    }

    /// Restores the factory settings.
    pub fn factory_reset(firmware: Firmware, id: u8) -> Option<Self> {
        let bytes = match firmware {
            Firmware::Morpheus => morpheus(id, &[RESET])?,
            Firmware::Stock => stock(id, &Instruction::FactoryReset)?,
            Firmware::XSeries => x_series(id, &protocol2::Instruction::FactoryReset(RESET_ALL))?,
        };
        let request = Self::new(firmware, id, bytes, 1);
        Some(Self {
            execution_time: EEPROM_ALL,
            ..request
        })
    }

    fn new(firmware: Firmware, id: u8, bytes: Vec<u8>, reply_data: usize) -> Self {
        Self {
            firmware,
            id,
            bytes,
            reply_data,
            execution_time: Duration::ZERO,
            plan: None,
        }
    }

    /// Requested part of a reply's payload; `None` if the payload does not match the
    /// request.
    pub fn wanted<'a>(&self, payload: &'a [u8]) -> Option<&'a [u8]> {
        match &self.plan {
            Some(plan) => plan.extract(payload),
            None => Some(payload),
        }
    }
}

fn stock(id: u8, instruction: &Instruction) -> Option<Vec<u8>> {
    Firmware::Stock.has_id(id).then_some(())?;
    let bytes = instruction.encode::<FRAME_MAX>(id)?;
    Some(bytes.to_vec())
}

fn x_series(id: u8, instruction: &protocol2::Instruction) -> Option<Vec<u8>> {
    Firmware::XSeries.has_id(id).then_some(())?;
    let bytes = instruction.encode::<FRAME_MAX>(id)?;
    Some(bytes.to_vec())
}

fn morpheus(id: u8, data: &[u8]) -> Option<Vec<u8>> {
    let frame = Frame {
        destination: ServoId::new(id)?.get(),
        source: MASTER,
        data,
    };
    let bytes = frame.encode::<{ frame::FRAME_MAX }>()?;
    Some(bytes.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo_table::{AX12A, MORPHEUS};

    #[test]
    fn writes_and_resets_are_as_recorded() {
        let pwm = MORPHEUS.by_name("pwm").unwrap();
        let request = Request::write(Firmware::Morpheus, 1, pwm, 1500).unwrap();
        assert_eq!(request.bytes, [0xAA, 6, 1, 0xFE, 3, 0x10, 0xDC, 5, 0]);
        let request = Request::factory_reset(Firmware::Stock, 0).unwrap();
        assert_eq!(request.bytes, [0xFF, 0xFF, 0, 2, 6, 0xF7]);
        let goal = AX12A.by_name("goal_position").unwrap();
        let request = Request::write(Firmware::Stock, 1, goal, 512).unwrap();
        assert_eq!(request.bytes, [0xFF, 0xFF, 1, 5, 3, 30, 0, 2, 0xD6]);
    }

    #[test]
    fn impossible_ids_have_no_request() {
        assert!(Request::ping(Firmware::Morpheus, 0).is_none());
        assert!(Request::ping(Firmware::Stock, 0).is_some());
        for firmware in Firmware::ALL {
            let has_253 = firmware != Firmware::XSeries;
            assert_eq!(Request::ping(firmware, 253).is_some(), has_253);
            assert!(Request::ping(firmware, 254).is_none());
            assert!(Request::ping(firmware, 255).is_none());
            assert!(Request::factory_reset(firmware, 254).is_none());
        }
    }
}
