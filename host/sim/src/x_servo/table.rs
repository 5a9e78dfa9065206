//! Control table of a model as data: address, size, access, initial value and range of each
//! register (e-Manual, "Control Table of EEPROM Area", "... RAM Area").
//!
//! Values are signed numbers of up to four bytes; a register is signed where its range is. Ranges
//! are those of the e-Manual, except that
//! - a protocol type other than 2 is refused: this servo has no other;
//! - a secondary id may be anything, since one above 252 means none;
//! - the goal of a position is limited by the operating mode, see `memory`.

use armbridge_servo::protocol2::model::Model;
use armbridge_servo::protocol2::register as at;

use super::specification::Specification;

/// First address of the RAM; the registers below are EEPROM.
pub(super) const RAM: u16 = at::TORQUE_ENABLE;
/// Firmware version: one of those that have all instructions (Fast Sync Read is the newest).
/// Nothing depends on it.
const FIRMWARE_VERSION: i32 = 46;
/// Counts of 256 turns, the range of multi-turn positions.
pub(super) const TURNS_MAX_COUNTS: i32 = 1_048_575;
/// Bits of the drive mode that are in use: reverse, time-based profile, torque on by goal update.
pub(super) const DRIVE_MODE_BITS: i32 = 0b1101;

/// A register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Register {
    pub(super) address: u16,
    pub(super) bytes: u16,
    pub(super) initial: i32,
    /// Smallest and largest value that can be written; `None` if it is only read.
    pub(super) range: Option<[i32; 2]>,
}

impl Register {
    pub(super) const fn end(&self) -> u16 {
        self.address + self.bytes
    }

    pub(super) const fn is_persistent(&self) -> bool {
        self.address < RAM
    }

    pub(super) const fn contains(&self, address: u16) -> bool {
        self.address <= address && address < self.end()
    }

    /// The number in these bytes.
    pub(super) fn value(&self, bytes: &[u8]) -> i32 {
        let is_signed = self.range.is_none_or(|[lowest, _]| lowest < 0);
        let is_negative = is_signed && bytes.last().is_some_and(|last| last & 0x80 != 0);
        let mut all = if is_negative { [0xFF; 4] } else { [0; 4] };
        for (to, from) in all.iter_mut().zip(bytes) {
            *to = *from;
        }
        i32::from_le_bytes(all)
    }
}

const fn read(address: u16, bytes: u16, initial: i32) -> Register {
    Register {
        address,
        bytes,
        initial,
        range: None,
    }
}

const fn write(address: u16, bytes: u16, initial: i32, lowest: i32, highest: i32) -> Register {
    Register {
        address,
        bytes,
        initial,
        range: Some([lowest, highest]),
    }
}

/// The registers of a model, in the order of their addresses.
pub(super) fn registers(model: &Model, specification: &Specification) -> Vec<Register> {
    let mut all = eeprom(model, specification);
    all.extend(ram(model, specification));
    for block in specification.indirect {
        let last = i32::from(end(specification)) - 1;
        for index in 0..block.count {
            let (address, data) = (block.addresses + 2 * index, block.data + index);
            all.push(write(address, 2, data.into(), RAM.into(), last));
            all.push(write(data, 1, 0, 0, 255));
        }
    }
    all.sort_by_key(|register| register.address);
    all
}

/// End of the table.
pub(super) fn end(specification: &Specification) -> u16 {
    let blocks = specification.indirect.iter();
    blocks
        .map(|block| block.data + block.count)
        .max()
        .unwrap_or(RAM)
}

fn eeprom(model: &Model, specification: &Specification) -> Vec<Register> {
    let full = i32::from(model.full_pwm);
    let last_count = i32::from(model.counts_per_turn) - 1;
    let [supply_min, supply_max, supply_initial] = specification.supply_decivolt;
    let [velocity, velocity_max] = specification.velocity_limit;
    let mut all = vec![
        read(at::MODEL_NUMBER, 2, model.number.into()),
        read(at::MODEL_INFORMATION, 4, 0),
        read(at::FIRMWARE_VERSION, 1, FIRMWARE_VERSION),
        write(at::ID, 1, 1, 0, 252),
        write(at::BAUD_RATE, 1, 1, 0, specification.baud_max),
        write(at::RETURN_DELAY, 1, 250, 0, 254),
        write(at::DRIVE_MODE, 1, 0, 0, DRIVE_MODE_BITS),
        write(at::OPERATING_MODE, 1, 3, 0, 16),
        write(at::SHADOW_ID, 1, 255, 0, 255),
        write(at::PROTOCOL_TYPE, 1, 2, 2, 2),
        write(at::HOMING_OFFSET, 4, 0, -1_044_479, 1_044_479),
        write(at::MOVING_THRESHOLD, 4, 10, 0, 1_023),
        write(at::TEMPERATURE_LIMIT, 1, model.temperature_c.into(), 0, 100),
        write(at::MAX_VOLTAGE_LIMIT, 2, supply_max, supply_min, supply_max),
        write(
            at::MIN_VOLTAGE_LIMIT,
            2,
            supply_initial,
            supply_min,
            supply_max,
        ),
        write(at::PWM_LIMIT, 2, full, 0, full),
        write(at::VELOCITY_LIMIT, 4, velocity, 0, velocity_max),
        write(at::MAX_POSITION_LIMIT, 4, last_count, 0, last_count),
        write(at::MIN_POSITION_LIMIT, 4, 0, 0, last_count),
        write(at::STARTUP_CONFIGURATION, 1, 0, 0, 3),
        write(at::SHUTDOWN, 1, specification.shutdown, 0, 0x3F),
    ];
    if let Some(current) = model.current {
        let most = current.most_counts.into();
        all.push(write(at::CURRENT_LIMIT, 2, most, 0, most));
    }
    if let Some(slope) = specification.slope {
        all.push(write(at::PWM_SLOPE, 1, slope.initial, 1, 255));
    }
    all
}

fn ram(model: &Model, specification: &Specification) -> Vec<Register> {
    /// Range of the gains.
    const GAIN_MAX: i32 = 16_383;
    /// Range of the profile.
    const PROFILE_MAX: i32 = 32_767;

    let full = i32::from(model.full_pwm);
    let velocity_max = specification.velocity_limit[1];
    let [velocity_i, velocity_p, position_d, position_i, position_p] = specification.gains;
    let gain = |address, initial| write(address, 2, initial, 0, GAIN_MAX);
    let mut all = vec![
        write(at::TORQUE_ENABLE, 1, 0, 0, 1),
        write(at::LED, 1, 0, 0, 1),
        write(at::STATUS_RETURN_LEVEL, 1, 2, 0, 2),
        read(at::REGISTERED_INSTRUCTION, 1, 0),
        read(at::HARDWARE_ERROR, 1, 0),
        gain(at::VELOCITY_I_GAIN, velocity_i),
        gain(at::VELOCITY_P_GAIN, velocity_p),
        gain(at::POSITION_D_GAIN, position_d),
        gain(at::POSITION_I_GAIN, position_i),
        gain(at::POSITION_P_GAIN, position_p),
        gain(at::FEEDFORWARD_2ND_GAIN, 0),
        gain(at::FEEDFORWARD_1ST_GAIN, 0),
        write(at::BUS_WATCHDOG, 1, 0, 0, 127),
        write(at::GOAL_PWM, 2, full, -full, full),
        write(at::GOAL_VELOCITY, 4, 0, -velocity_max, velocity_max),
        write(at::PROFILE_ACCELERATION, 4, 0, 0, PROFILE_MAX),
        write(at::PROFILE_VELOCITY, 4, 0, 0, PROFILE_MAX),
        write(at::GOAL_POSITION, 4, 0, -TURNS_MAX_COUNTS, TURNS_MAX_COUNTS),
        read(at::REALTIME_TICK, 2, 0),
        read(at::MOVING, 1, 0),
        read(at::MOVING_STATUS, 1, 0),
        read(at::PRESENT_PWM, 2, 0),
        read(at::PRESENT_CURRENT, 2, 0),
        read(at::PRESENT_VELOCITY, 4, 0),
        read(at::PRESENT_POSITION, 4, 0),
        read(at::VELOCITY_TRAJECTORY, 4, 0),
        read(at::POSITION_TRAJECTORY, 4, 0),
        read(at::PRESENT_VOLTAGE, 2, 0),
        read(at::PRESENT_TEMPERATURE, 1, 0),
        read(at::BACKUP_READY, 1, 0),
    ];
    if let Some(current) = model.current {
        let most = i32::from(current.most_counts);
        all.push(write(at::GOAL_CURRENT, 2, most, -most, most));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::specification;
    use super::*;
    use armbridge_client::servo_table::{Access, Storage, X_SERIES};
    use armbridge_servo::protocol2::model::MODELS;

    #[test]
    fn registers_do_not_overlap_and_begin_within_their_ranges() {
        for model in &MODELS {
            let specification = specification::find(model);
            let all = registers(model, specification);
            for two in all.windows(2) {
                assert!(two[0].end() <= two[1].address, "{}: {two:?}", model.name);
            }
            for register in &all {
                let [lowest, highest] = register.range.unwrap_or([i32::MIN, i32::MAX]);
                let is_within = lowest <= register.initial && register.initial <= highest;
                assert!(is_within, "{}: {register:?}", model.name);
            }
            let last = all.last().map(Register::end);
            assert_eq!(last, Some(end(specification)));
        }
    }

    /// The tools know no register that a servo does not have, but for those of the current.
    #[test]
    fn the_tools_have_the_same_table() {
        for model in &MODELS {
            let all = registers(model, specification::find(model));
            for known in X_SERIES.registers {
                let own = all.iter().find(|own| own.address == known.address);
                let Some(own) = own else {
                    let is_current = matches!(known.address, at::CURRENT_LIMIT | at::GOAL_CURRENT);
                    assert!(is_current && model.current.is_none(), "{}", known.name);
                    continue;
                };
                assert_eq!(own.bytes, known.size.bytes(), "{}", known.name);
                let is_written = known.access == Access::ReadWrite;
                assert_eq!(own.range.is_some(), is_written, "{}", known.name);
                let is_persistent = known.storage == Storage::Eeprom;
                assert_eq!(own.is_persistent(), is_persistent, "{}", known.name);
            }
        }
    }

    #[test]
    fn numbers_have_the_sign_of_their_range() {
        let goal = write(at::GOAL_PWM, 2, 0, -885, 885);
        assert_eq!(goal.value(&(-300_i16).to_le_bytes()), -300);
        let gain = write(at::POSITION_P_GAIN, 2, 0, 0, 16_383);
        assert_eq!(gain.value(&[0xFF, 0xFF]), 0xFFFF);
    }
}
