//! Settings of stock and X servos that a set-up changes: their registers, as data, and what they
//! are in a servo that is ready for torque.

use crate::tick::limits::ROW_TICKS;
use armbridge_servo::master::timing::RETURN_DELAY_US;
use armbridge_servo::protocol2::model::OperatingMode;
use armbridge_servo::{Firmware, protocol1, protocol2};

/// Status return level with which READ is answered and WRITE is not: the least that a
/// tick needs.
pub(super) const LEVEL_READ: u8 = 1;
/// Unit of the watchdog of an X servo in µs (e-Manual, "Bus Watchdog").
const WATCHDOG_US: u32 = 20_000;
/// Largest setting of the watchdog, in units.
const WATCHDOG_MAX: u32 = 127;

/// Silence of the bus after which an X servo switches its motor off, in units of 20 ms: not before
/// the board does, which allows [`ROW_TICKS`] samples to be missing. One up to a period of 4 ms.
pub(super) fn watchdog(period_us: u32) -> u8 {
    let units = ROW_TICKS.saturating_mul(period_us).div_ceil(WATCHDOG_US);
    units.clamp(1, WATCHDOG_MAX) as u8
}

/// Bytes of the registers that are read, from address 0 on: of an X servo through the goal PWM.
const IMAGE_BYTES: usize = protocol2::register::GOAL_PWM as usize + 2;

/// Registers of a set-up, and what they have in a servo that is ready.
pub(super) struct Registers {
    pub(super) return_delay: u16,
    /// In units of 2 µs.
    ready_delay: u8,
    /// What selects open-loop control: address, bytes, and their contents.
    pub(super) mode: u16,
    pub(super) mode_bytes: usize,
    ready_mode: [u8; 4],
    pub(super) level: u16,
    pub(super) torque: u16,
    /// What is read: first addresses and numbers of bytes. No READ goes across addresses without a
    /// register, of which the e-Manual of the X series does not say what a servo answers.
    pub(super) reads: &'static [(u16, u16)],
}

/// Both angle limits 0 are wheel mode.
const AX12A: Registers = Registers {
    return_delay: protocol1::register::RETURN_DELAY,
    ready_delay: (RETURN_DELAY_US / 2) as u8,
    mode: protocol1::register::ANGLE_LIMITS,
    mode_bytes: 4,
    ready_mode: [0; 4],
    level: protocol1::register::STATUS_RETURN_LEVEL,
    torque: protocol1::register::TORQUE_ENABLE,
    reads: &[(
        protocol1::register::RETURN_DELAY,
        protocol1::register::TORQUE_ENABLE + 1 - protocol1::register::RETURN_DELAY,
    )],
};

const X: Registers = Registers {
    return_delay: protocol2::register::RETURN_DELAY,
    ready_delay: (protocol2::RETURN_DELAY_US / 2) as u8,
    mode: protocol2::register::OPERATING_MODE,
    mode_bytes: 1,
    ready_mode: [OperatingMode::Pwm.code(), 0, 0, 0],
    level: protocol2::register::STATUS_RETURN_LEVEL,
    torque: protocol2::register::TORQUE_ENABLE,
    // Return delay, drive mode and operating mode are neighbours.
    reads: &[
        (protocol2::register::RETURN_DELAY, 3),
        (protocol2::register::TORQUE_ENABLE, 1),
        (protocol2::register::STATUS_RETURN_LEVEL, 1),
        (protocol2::register::BUS_WATCHDOG, 1),
        (protocol2::register::GOAL_PWM, 2),
    ],
};

impl Registers {
    /// Those of a firmware; Morpheus needs no set-up.
    pub(super) fn of(firmware: Firmware) -> Option<&'static Self> {
        match firmware {
            Firmware::Morpheus => None,
            Firmware::Stock => Some(&AX12A),
            Firmware::XSeries => Some(&X),
        }
    }
}

/// Registers of one servo as they are read piece by piece, from address 0 on.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegisterImage([u8; IMAGE_BYTES]);

impl Default for RegisterImage {
    fn default() -> Self {
        Self([0; IMAGE_BYTES])
    }
}

impl RegisterImage {
    /// Takes the data of a read from this address on.
    pub(super) fn store(&mut self, address: u16, data: &[u8]) {
        let start = usize::from(address);
        if let Some(bytes) = self.0.get_mut(start..start + data.len()) {
            bytes.copy_from_slice(data);
        }
    }
}

/// Settings of a servo that the bridge changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ServoSettings {
    firmware: Firmware,
    pub(super) return_delay: u8,
    /// Angle limits, or the operating mode.
    pub(super) mode: [u8; 4],
    /// Torque limit at power-up of a stock servo.
    pub(super) max_torque: [u8; 2],
    /// Status return level.
    pub(super) level: u8,
    /// Torque enable, which is no setting.
    torque: u8,
    /// The watchdog of an X servo and its goal PWM, which are none either.
    watchdog: u8,
    goal_pwm: [u8; 2],
}

impl ServoSettings {
    /// Decodes the registers, once all are read.
    pub(super) fn decode(firmware: Firmware, image: &RegisterImage) -> Option<Self> {
        let registers = Registers::of(firmware)?;
        let from = |address: u16| image.0.get(usize::from(address)..);
        let byte = |address: u16| from(address)?.first().copied();
        let mut mode = [0; 4];
        let bytes = from(registers.mode)?.get(..registers.mode_bytes)?;
        mode.get_mut(..registers.mode_bytes)?.copy_from_slice(bytes);
        let is_stock = firmware == Firmware::Stock;
        Some(Self {
            firmware,
            return_delay: byte(registers.return_delay)?,
            mode,
            max_torque: if is_stock {
                *from(protocol1::register::MAX_TORQUE)?.first_chunk()?
            } else {
                [0; 2]
            },
            level: byte(registers.level)?,
            torque: byte(registers.torque)?,
            watchdog: if is_stock {
                0
            } else {
                byte(protocol2::register::BUS_WATCHDOG)?
            },
            goal_pwm: if is_stock {
                [0; 2]
            } else {
                *from(protocol2::register::GOAL_PWM)?.first_chunk()?
            },
        })
    }

    /// These settings as they are in a servo that takes torque.
    pub(super) fn made_ready(self) -> Option<Self> {
        let registers = Registers::of(self.firmware)?;
        Some(Self {
            return_delay: registers.ready_delay,
            mode: registers.ready_mode,
            level: self.level.max(LEVEL_READ),
            ..self
        })
    }

    /// Whether the servo takes torque with these settings.
    pub(super) fn are_ready(self) -> bool {
        Registers::of(self.firmware).is_some_and(|registers| {
            self.return_delay == registers.ready_delay
                && self.mode == registers.ready_mode
                && self.level > 0
        })
    }

    /// Whether torque can be enabled without a motion.
    pub(super) fn are_safe(self, watchdog: u8) -> bool {
        self.are_ready() && self.has_watchdog(watchdog) && self.goal_pwm == [0; 2]
    }

    /// Whether it would obey a torque now.
    pub(super) fn are_in_force(self, watchdog: u8) -> bool {
        self.are_ready() && self.torque == 1 && self.has_watchdog(watchdog)
    }

    /// Whether its watchdog, if it has one, is set to this.
    fn has_watchdog(self, watchdog: u8) -> bool {
        self.firmware != Firmware::XSeries || self.watchdog == watchdog
    }
}
