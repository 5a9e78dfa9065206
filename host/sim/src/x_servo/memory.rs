//! Control table of a servo: persistent and volatile bytes, and the checks of a write.
//!
//! A write is checked as a whole, and nothing is written with an error. The first of these holds:
//!
//! | error       | condition                                                          |
//! |-------------|--------------------------------------------------------------------|
//! | access      | no register, or one only read; EEPROM with torque on, or by the secondary id |
//! | data length | a part of a register                                               |
//! | data range  | outside the register's range; a goal while the bus watchdog is triggered |
//! | data limit  | a goal beyond the limit that another register sets                 |
//! | result fail | torque on after a shutdown                                         |
//!
//! All but the last, and the order, are from the e-Manual ("Protocol 2.0, Error", "Bus Watchdog",
//! "Indirect Address"). A read of an address without a register is an access error too, so that a
//! block across a gap is refused. Indirect data are those of the address that the indirect address
//! has, in every respect; one that points to indirect data gives its own byte.

use armbridge_servo::protocol2::StatusError;
use armbridge_servo::protocol2::model::{Model, OperatingMode};
use armbridge_servo::protocol2::register as at;

use super::specification::Specification;
use super::table::{self, DRIVE_MODE_BITS, Register, TURNS_MAX_COUNTS};

/// Value of the bus watchdog after it has triggered: -1.
pub(super) const WATCHDOG_TRIGGERED: u8 = 0xFF;
/// Registers of goals, which are read only while the bus watchdog is triggered.
pub(super) const GOALS: [u16; 4] = [
    at::GOAL_PWM,
    at::GOAL_CURRENT,
    at::GOAL_VELOCITY,
    at::GOAL_POSITION,
];

/// Bytes at their addresses, indirect ones resolved.
pub(super) type Write = Vec<(u16, u8)>;

/// The bytes of the control table.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    registers: Vec<Register>,
    bytes: Vec<u8>,
    specification: &'static Specification,
    has_current: bool,
    /// A hardware error has switched torque off: only a reboot permits it again.
    pub(super) is_shut_down: bool,
}

impl Memory {
    /// Factory settings, powered up.
    pub(super) fn new(model: &Model, specification: &'static Specification) -> Self {
        let mut memory = Self {
            registers: table::registers(model, specification),
            bytes: vec![0; table::end(specification).into()],
            specification,
            has_current: model.current.is_some(),
            is_shut_down: false,
        };
        memory.reset_eeprom();
        memory.power_up();
        memory
    }

    /// Resets the RAM to its initial values.
    pub(super) fn power_up(&mut self) {
        self.bytes[usize::from(table::RAM)..].fill(0);
        self.restore(|register| !register.is_persistent());
        self.reset_goals();
        self.is_shut_down = false;
    }

    /// Restores the factory settings of the EEPROM.
    pub(super) fn reset_eeprom(&mut self) {
        self.restore(Register::is_persistent);
    }

    /// Resets gains, profile and goals, as a new operating mode does.
    pub(super) fn reset_control(&mut self) {
        self.restore(|register| {
            let is_gain = (at::VELOCITY_I_GAIN..at::BUS_WATCHDOG).contains(&register.address);
            let profile = [at::PROFILE_ACCELERATION, at::PROFILE_VELOCITY];
            is_gain || profile.contains(&register.address)
        });
        self.reset_goals();
    }

    fn reset_goals(&mut self) {
        self.set_short(at::GOAL_PWM, self.short(at::PWM_LIMIT));
        if self.has_current {
            self.set_short(at::GOAL_CURRENT, self.short(at::CURRENT_LIMIT));
        }
        self.set_long(at::GOAL_VELOCITY, 0);
    }

    fn restore(&mut self, is_concerned: impl Fn(&Register) -> bool) {
        for register in &self.registers {
            if is_concerned(register) {
                let (start, end) = (register.address.into(), register.end().into());
                let count = end - start;
                self.bytes[start..end].copy_from_slice(&register.initial.to_le_bytes()[..count]);
            }
        }
    }

    pub(super) fn byte(&self, address: u16) -> u8 {
        self.bytes[usize::from(address)]
    }

    pub(super) fn short(&self, address: u16) -> i16 {
        i16::from_le_bytes([self.byte(address), self.byte(address + 1)])
    }

    pub(super) fn long(&self, address: u16) -> i32 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|index| self.byte(address + index));
        i32::from_le_bytes([a, b, c, d])
    }

    pub(super) fn set_byte(&mut self, address: u16, value: u8) {
        self.bytes[usize::from(address)] = value;
    }

    pub(super) fn set_short(&mut self, address: u16, value: i16) {
        self.put(address, &value.to_le_bytes());
    }

    pub(super) fn set_long(&mut self, address: u16, value: i32) {
        self.put(address, &value.to_le_bytes());
    }

    fn put(&mut self, address: u16, data: &[u8]) {
        let start = usize::from(address);
        self.bytes[start..start + data.len()].copy_from_slice(data);
    }

    pub(super) fn torque_on(&self) -> bool {
        self.byte(at::TORQUE_ENABLE) != 0
    }

    pub(super) fn is_reverse(&self) -> bool {
        self.byte(at::DRIVE_MODE) & 1 != 0
    }

    pub(super) fn has_mode(&self, modes: &[OperatingMode]) -> bool {
        let code = self.byte(at::OPERATING_MODE);
        modes.iter().any(|mode| mode.code() == code)
    }

    /// Value of the register at this address.
    pub(super) fn value(&self, address: u16) -> Option<i32> {
        let register = self.register_at(address)?;
        let bytes = self
            .bytes
            .get(register.address.into()..register.end().into())?;
        Some(register.value(bytes))
    }

    fn register_at(&self, address: u16) -> Option<&Register> {
        let after = self.registers.partition_point(|r| r.address <= address);
        let register = self.registers.get(after.checked_sub(1)?)?;
        register.contains(address).then_some(register)
    }

    /// Address that is meant by one of indirect data, else the same.
    fn resolve(&self, address: u16) -> u16 {
        let mut blocks = self.specification.indirect.iter();
        let block = blocks.find(|block| (block.data..block.data + block.count).contains(&address));
        block.map_or(address, |block| {
            let pointer = block.addresses + 2 * (address - block.data);
            self.short(pointer).unsigned_abs()
        })
    }

    /// `count` bytes from `address` on.
    ///
    /// # Errors
    /// [`StatusError::Access`] if one of them is in no register, [`StatusError::DataLength`] if
    /// there are none.
    pub(super) fn read(&self, address: u16, count: u16) -> Result<Vec<u8>, StatusError> {
        if count == 0 {
            return Err(StatusError::DataLength);
        }
        let end = address.checked_add(count).ok_or(StatusError::Access)?;
        let byte = |address| {
            let resolved = self.resolve(address);
            let is_known = [address, resolved]
                .iter()
                .all(|at| self.register_at(*at).is_some());
            is_known
                .then(|| self.byte(resolved))
                .ok_or(StatusError::Access)
        };
        (address..end).map(byte).collect()
    }

    /// Checks writing `data` at `address`, by the secondary id or not.
    ///
    /// # Errors
    /// The error of the status packet.
    pub(super) fn check(
        &self,
        address: u16,
        data: &[u8],
        is_by_shadow_id: bool,
    ) -> Result<Write, StatusError> {
        let mut writes = Write::new();
        for (index, byte) in data.iter().enumerate() {
            let index = u16::try_from(index).map_err(|_| StatusError::Access)?;
            let address = address.checked_add(index).ok_or(StatusError::Access)?;
            self.register_at(address).ok_or(StatusError::Access)?;
            writes.push((self.resolve(address), *byte));
        }
        let mut touched: Vec<&Register> = Vec::new();
        for (address, _) in &writes {
            let register = self.register_at(*address).ok_or(StatusError::Access)?;
            let is_locked = register.is_persistent() && (self.torque_on() || is_by_shadow_id);
            if register.range.is_none() || is_locked {
                return Err(StatusError::Access);
            }
            if !touched.contains(&register) {
                touched.push(register);
            }
        }
        let mut after = self.bytes.clone();
        for (address, byte) in &writes {
            after[usize::from(*address)] = *byte;
        }
        for register in &touched {
            let is_written = |address| writes.iter().any(|(written, _)| *written == address);
            if !(register.address..register.end()).all(is_written) {
                return Err(StatusError::DataLength);
            }
        }
        for register in touched {
            let bytes = &after[register.address.into()..register.end().into()];
            self.check_value(register, register.value(bytes))?;
        }
        Ok(writes)
    }

    /// Checks a value against range and limits.
    fn check_value(&self, register: &Register, value: i32) -> Result<(), StatusError> {
        let is_triggered = self.byte(at::BUS_WATCHDOG) == WATCHDOG_TRIGGERED;
        let [lowest, highest] = register.range.unwrap_or_default();
        let is_permitted = match register.address {
            at::DRIVE_MODE => value & !DRIVE_MODE_BITS == 0,
            at::OPERATING_MODE => self.is_mode(value),
            // Only 0 clears it.
            at::BUS_WATCHDOG => !is_triggered || value == 0,
            address => !is_triggered || !GOALS.contains(&address),
        };
        if !is_permitted || value < lowest || value > highest {
            return Err(StatusError::DataRange);
        }
        let [lowest, highest] = self.limits(register.address);
        if value < lowest || value > highest {
            return Err(StatusError::DataLimit);
        }
        if register.address == at::TORQUE_ENABLE && value != 0 && self.is_shut_down {
            return Err(StatusError::Failed);
        }
        Ok(())
    }

    fn is_mode(&self, code: i32) -> bool {
        use OperatingMode as Mode;
        let all = [
            Mode::Velocity,
            Mode::Position,
            Mode::ExtendedPosition,
            Mode::Pwm,
        ];
        let with_current = [Mode::Current, Mode::CurrentBasedPosition];
        let is_in = |modes: &[Mode]| modes.iter().any(|mode| i32::from(mode.code()) == code);
        is_in(&all) || (self.has_current && is_in(&with_current))
    }

    /// Limits that other registers set to a goal.
    fn limits(&self, address: u16) -> [i32; 2] {
        let either_way = |limit: i32| [-limit, limit];
        match address {
            at::GOAL_PWM => either_way(self.short(at::PWM_LIMIT).into()),
            at::GOAL_CURRENT => either_way(self.short(at::CURRENT_LIMIT).into()),
            at::GOAL_VELOCITY => either_way(self.long(at::VELOCITY_LIMIT)),
            at::GOAL_POSITION if self.has_mode(&[OperatingMode::Position]) => [
                self.long(at::MIN_POSITION_LIMIT),
                self.long(at::MAX_POSITION_LIMIT),
            ],
            at::GOAL_POSITION => either_way(TURNS_MAX_COUNTS),
            _ => [i32::MIN, i32::MAX],
        }
    }

    /// Writes checked bytes.
    pub(super) fn write(&mut self, writes: &[(u16, u8)]) {
        for (address, byte) in writes {
            self.set_byte(*address, *byte);
        }
    }
}

#[cfg(test)]
mod tests;
