//! Control table: persistent and volatile bytes, and the checks of a write.
//!
//! Addresses without a register read 0, and writes to them are dropped. A write is
//! checked as a whole: nothing is written if a value is out of its register's range, a
//! register is read-only, or an address is beyond the table.

use std::ops::RangeInclusive;

use armbridge_client::servo_table::{AX12A, Access, Register, Storage};
use armbridge_servo::Alarms;

/// Bytes of the table.
pub(super) const SIZE: usize = AX12A.size as usize;
/// First address of the RAM; the bytes below are persistent.
const RAM: u8 = at::TORQUE_ENABLE;
/// Registers that can still be written when [`at::LOCK`] is set (manual of 2006, "Lock").
const NEVER_LOCKED: RangeInclusive<u16> = at::TORQUE_ENABLE as u16..=at::TORQUE_LIMIT as u16;
/// Firmware version of current servos. Nothing depends on it.
const FIRMWARE_VERSION: u8 = 24;

/// Addresses of registers that the servo itself uses.
pub(super) mod at {
    pub(in super::super) const FIRMWARE_VERSION: u8 = 2;
    pub(in super::super) const ID: u8 = 3;
    pub(in super::super) const BAUD_RATE: u8 = 4;
    pub(in super::super) const RETURN_DELAY: u8 = 5;
    pub(in super::super) const CW_ANGLE_LIMIT: u8 = 6;
    pub(in super::super) const CCW_ANGLE_LIMIT: u8 = 8;
    pub(in super::super) const TEMPERATURE_LIMIT: u8 = 11;
    pub(in super::super) const MIN_VOLTAGE: u8 = 12;
    pub(in super::super) const MAX_VOLTAGE: u8 = 13;
    pub(in super::super) const MAX_TORQUE: u8 = 14;
    pub(in super::super) const STATUS_RETURN_LEVEL: u8 = 16;
    pub(in super::super) const SHUTDOWN: u8 = 18;
    pub(in super::super) const TORQUE_ENABLE: u8 = 24;
    pub(in super::super) const CW_MARGIN: u8 = 26;
    pub(in super::super) const CCW_MARGIN: u8 = 27;
    pub(in super::super) const CW_SLOPE: u8 = 28;
    pub(in super::super) const CCW_SLOPE: u8 = 29;
    pub(in super::super) const GOAL_POSITION: u8 = 30;
    pub(in super::super) const MOVING_SPEED: u8 = 32;
    pub(in super::super) const TORQUE_LIMIT: u8 = 34;
    pub(in super::super) const PRESENT_POSITION: u8 = 36;
    pub(in super::super) const PRESENT_SPEED: u8 = 38;
    pub(in super::super) const PRESENT_LOAD: u8 = 40;
    pub(in super::super) const PRESENT_VOLTAGE: u8 = 42;
    pub(in super::super) const PRESENT_TEMPERATURE: u8 = 43;
    pub(in super::super) const REGISTERED: u8 = 44;
    pub(in super::super) const MOVING: u8 = 46;
    pub(in super::super) const LOCK: u8 = 47;
    pub(in super::super) const PUNCH: u8 = 48;
}

/// The bytes of the control table.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    bytes: [u8; SIZE],
}

impl Memory {
    /// Factory settings, powered up.
    pub(super) fn new() -> Self {
        let mut memory = Self { bytes: [0; SIZE] };
        memory.bytes[usize::from(at::FIRMWARE_VERSION)] = FIRMWARE_VERSION;
        memory.restore(Storage::Eeprom);
        memory.power_up();
        memory
    }

    /// Resets everything but the EEPROM to its initial value.
    pub(super) fn power_up(&mut self) {
        self.bytes[usize::from(RAM)..].fill(0);
        self.restore(Storage::Ram);
        self.set_word(at::TORQUE_LIMIT, self.word(at::MAX_TORQUE));
    }

    /// Restores the factory settings of the EEPROM.
    pub(super) fn reset(&mut self) {
        self.restore(Storage::Eeprom);
    }

    fn restore(&mut self, storage: Storage) {
        for register in AX12A.registers.iter().filter(|r| r.storage == storage) {
            if let Some(value) = register.initial {
                self.put(register.address, &register.bytes_of(value));
            }
        }
    }

    pub(super) fn byte(&self, address: u8) -> u8 {
        self.bytes[usize::from(address)]
    }

    pub(super) fn word(&self, address: u8) -> u16 {
        u16::from_le_bytes([self.byte(address), self.byte(address + 1)])
    }

    pub(super) fn set_byte(&mut self, address: u8, value: u8) {
        self.bytes[usize::from(address)] = value;
    }

    pub(super) fn set_word(&mut self, address: u8, value: u16) {
        self.put(address.into(), &value.to_le_bytes());
    }

    fn put(&mut self, address: u16, data: &[u8]) {
        let start = usize::from(address);
        self.bytes[start..start + data.len()].copy_from_slice(data);
    }

    /// `count` bytes from `address` on; `None` if they are not all in the table.
    pub(super) fn read(&self, address: u16, count: u16) -> Option<&[u8]> {
        let start = usize::from(address);
        self.bytes.get(start..start + usize::from(count))
    }

    /// Whether both angle limits are 0: wheel mode.
    pub(super) fn is_wheel(&self) -> bool {
        self.word(at::CW_ANGLE_LIMIT) == 0 && self.word(at::CCW_ANGLE_LIMIT) == 0
    }

    /// Whether torque is on, and its limit is not 0.
    pub(super) fn torque_on(&self) -> bool {
        self.byte(at::TORQUE_ENABLE) != 0 && self.word(at::TORQUE_LIMIT) != 0
    }

    /// Alarms of writing `data` at `address`.
    pub(super) fn check(&self, address: impl Into<u16>, data: &[u8]) -> Alarms {
        let address = address.into();
        let start = usize::from(address);
        let mut after = self.bytes;
        let Some(bytes) = after.get_mut(start..start + data.len()) else {
            return Alarms::RANGE;
        };
        bytes.copy_from_slice(data);
        let mut alarms = Alarms::NONE;
        for register in written(address, data.len()) {
            let value = register.value_in(&after, 0).unwrap_or_default();
            if !self.may_write(register) || !register.range.contains(&value) {
                return Alarms::RANGE;
            }
            let limits =
                self.word(at::CW_ANGLE_LIMIT).into()..=self.word(at::CCW_ANGLE_LIMIT).into();
            if register.address == u16::from(at::GOAL_POSITION)
                && !self.is_wheel()
                && !limits.contains(&value)
            {
                alarms = Alarms::ANGLE_LIMIT;
            }
        }
        alarms
    }

    fn may_write(&self, register: &Register) -> bool {
        let locked = self.byte(at::LOCK) != 0 && !NEVER_LOCKED.contains(&register.address);
        let in_use = register.storage == Storage::Eeprom && self.byte(at::TORQUE_ENABLE) != 0;
        register.access == Access::ReadWrite && !locked && !in_use
    }

    /// Writes checked bytes.
    pub(super) fn write(&mut self, address: impl Into<u16>, data: &[u8]) {
        let address = address.into();
        let first = usize::from(address);
        for register in written(address, data.len()) {
            for at in usize::from(register.address)..usize::from(register.end()) {
                if let Some(byte) = at.checked_sub(first).and_then(|index| data.get(index)) {
                    self.bytes[at] = *byte;
                }
            }
        }
    }
}

/// Registers that overlap `count` bytes from `address` on.
fn written(address: u16, count: usize) -> impl Iterator<Item = &'static Register> {
    let (start, end) = (usize::from(address), usize::from(address) + count);
    AX12A
        .registers
        .iter()
        .filter(move |r| usize::from(r.address) < end && start < usize::from(r.end()))
}

/// Number of EEPROM bytes among `count` bytes from `address` on.
pub(super) fn eeprom_bytes(address: u16, count: usize) -> u64 {
    let end = (usize::from(address) + count).min(usize::from(RAM));
    end.saturating_sub(usize::from(address)) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_those_of_the_table() {
        for (address, name) in [
            (at::FIRMWARE_VERSION, "firmware_version"),
            (at::ID, "id"),
            (at::BAUD_RATE, "baud_rate"),
            (at::RETURN_DELAY, "return_delay_time"),
            (at::CW_ANGLE_LIMIT, "cw_angle_limit"),
            (at::CCW_ANGLE_LIMIT, "ccw_angle_limit"),
            (at::TEMPERATURE_LIMIT, "temperature_limit"),
            (at::MIN_VOLTAGE, "min_voltage_limit"),
            (at::MAX_VOLTAGE, "max_voltage_limit"),
            (at::MAX_TORQUE, "max_torque"),
            (at::STATUS_RETURN_LEVEL, "status_return_level"),
            (at::SHUTDOWN, "shutdown"),
            (at::TORQUE_ENABLE, "torque_enable"),
            (at::CW_MARGIN, "cw_compliance_margin"),
            (at::CCW_MARGIN, "ccw_compliance_margin"),
            (at::CW_SLOPE, "cw_compliance_slope"),
            (at::CCW_SLOPE, "ccw_compliance_slope"),
            (at::GOAL_POSITION, "goal_position"),
            (at::MOVING_SPEED, "moving_speed"),
            (at::TORQUE_LIMIT, "torque_limit"),
            (at::PRESENT_POSITION, "present_position"),
            (at::PRESENT_SPEED, "present_speed"),
            (at::PRESENT_LOAD, "present_load"),
            (at::PRESENT_VOLTAGE, "present_voltage"),
            (at::PRESENT_TEMPERATURE, "present_temperature"),
            (at::REGISTERED, "registered"),
            (at::MOVING, "moving"),
            (at::LOCK, "lock"),
            (at::PUNCH, "punch"),
        ] {
            assert_eq!(
                AX12A.by_name(name).unwrap().address,
                u16::from(address),
                "{name}"
            );
        }
        for register in AX12A.registers {
            let is_persistent = register.storage == Storage::Eeprom;
            assert_eq!(
                is_persistent,
                register.address < u16::from(RAM),
                "{}",
                register.name
            );
        }
    }

    #[test]
    fn a_write_is_right_as_a_whole_or_not_done() {
        let mut memory = Memory::new();
        // Goal and speed at once, across two registers.
        assert_eq!(memory.check(30_u16, &[0x00, 2, 0x00, 1]), Alarms::NONE);
        // The second of them is too large; so is one that gets only its high byte.
        assert_eq!(memory.check(30_u16, &[0x00, 2, 0, 8]), Alarms::RANGE);
        assert_eq!(memory.check(31_u16, &[4]), Alarms::RANGE);
        // Only read, and beyond the end.
        assert_eq!(memory.check(36_u16, &[0, 0]), Alarms::RANGE);
        assert_eq!(memory.check(48_u16, &[32, 0, 0]), Alarms::RANGE);
        assert_eq!(memory.check(200_u16, &[0]), Alarms::RANGE);
        // Gaps take anything and keep nothing.
        assert_eq!(memory.check(18_u16, &[36, 7]), Alarms::NONE);
        memory.write(18_u16, &[4, 7]);
        assert_eq!(memory.read(18, 2), Some(&[4, 0][..]));
        assert_eq!(memory.read(49, 2), None);
    }

    #[test]
    fn torque_and_lock_close_the_eeprom() {
        let mut memory = Memory::new();
        memory.write(at::TORQUE_ENABLE, &[1]);
        assert_eq!(memory.check(at::ID, &[2]), Alarms::RANGE);
        memory.write(at::TORQUE_ENABLE, &[0]);
        assert_eq!(memory.check(at::ID, &[2]), Alarms::NONE);
        memory.write(at::LOCK, &[1]);
        for address in [at::ID, at::LOCK, at::PUNCH] {
            assert_eq!(memory.check(address, &[0]), Alarms::RANGE);
        }
        assert_eq!(memory.check(at::TORQUE_ENABLE, &[1]), Alarms::NONE);
        memory.power_up();
        assert_eq!(memory.check(at::ID, &[2]), Alarms::NONE);
    }

    #[test]
    fn power_off_forgets_the_ram_alone() {
        let mut memory = Memory::new();
        memory.write(at::MAX_TORQUE, &[0, 2]);
        memory.write(at::CW_SLOPE, &[64]);
        memory.power_up();
        assert_eq!(memory.word(at::MAX_TORQUE), 512);
        assert_eq!(memory.word(at::TORQUE_LIMIT), 512);
        assert_eq!(memory.byte(at::CW_SLOPE), 32);
        memory.reset();
        assert_eq!(memory.word(at::MAX_TORQUE), 1023);
        assert_eq!(memory.byte(at::FIRMWARE_VERSION), FIRMWARE_VERSION);
    }
}
