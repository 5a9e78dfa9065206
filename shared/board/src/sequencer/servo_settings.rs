//! Settings of stock and X servos that a set-up changes: their registers, as data, and what they
//! are in a servo that is ready for torque.

use crate::tick::LoopConfig;
use crate::tick::limits::ROW_TICKS;
use armbridge_servo::master::timing::RETURN_DELAY_US;
use armbridge_servo::protocol2::model::OperatingMode;
use armbridge_servo::{ControlMode, Firmware, protocol1, protocol2};

/// Status return level with which READ is answered and WRITE is not: the least that a
/// tick needs.
pub(super) const LEVEL_READ: u8 = 1;
/// Unit of the watchdog of an X servo in µs (e-Manual, "Bus Watchdog").
const WATCHDOG_US: u32 = 20_000;
/// Largest setting of the watchdog, in units.
const WATCHDOG_MAX: u32 = 127;

/// Most bytes of a servo's registers that are read, those of a stock servo.
const IMAGE_BYTES: usize = 20;
const _: () = assert!(AX12A.reads_fit() && X_PWM.reads_fit() && X_CURRENT.reads_fit());

/// What the board's settings require of X servos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct XRequirements {
    /// Silence of the bus after which a servo switches its motor off, in units of 20 ms.
    pub(super) watchdog: u8,
    pub(super) mode: ControlMode,
    /// Current that the servo's limit has to permit, in its counts: it ignores a goal beyond, and
    /// obeys the one before. 0 in PWM control mode.
    current_max: u16,
}

impl XRequirements {
    /// Those of this configuration.
    ///
    /// No watchdog ends a drive before the board does, which allows [`ROW_TICKS`] samples to be
    /// missing: it is 20 ms up to a period of 4 ms.
    // Not inlined, as what follows of the set-up: it is rare, and flash is short.
    #[inline(never)]
    pub(crate) fn of(config: &LoopConfig) -> Self {
        let period_us = config.period_us().get();
        let units = ROW_TICKS.saturating_mul(period_us).div_ceil(WATCHDOG_US);
        let mode = config.control_mode();
        Self {
            watchdog: units.clamp(1, WATCHDOG_MAX) as u8,
            mode,
            current_max: match mode {
                ControlMode::Pwm => 0,
                ControlMode::Current => config.limits().pwm_counts,
            },
        }
    }
}

/// Registers of a set-up, and what they have in a servo that is ready.
pub(super) struct Registers {
    pub(super) return_delay: u16,
    /// In units of 2 µs.
    ready_delay: u8,
    /// What selects open-loop control: address, bytes, their contents, and the bits that stay as
    /// they were found.
    pub(super) mode: u16,
    pub(super) mode_bytes: usize,
    ready_mode: [u8; 4],
    kept: [u8; 4],
    pub(super) level: u16,
    pub(super) torque: u16,
    /// What is read: first addresses and numbers of bytes. No READ goes across addresses without a
    /// register, of which the e-Manual of the X series does not say what a servo answers.
    pub(super) reads: Reads,
}

/// Both angle limits 0 are wheel mode.
const AX12A: Registers = Registers {
    return_delay: protocol1::register::RETURN_DELAY,
    ready_delay: (RETURN_DELAY_US / 2) as u8,
    mode: protocol1::register::ANGLE_LIMITS,
    mode_bytes: 4,
    ready_mode: [0; 4],
    kept: [0; 4],
    level: protocol1::register::STATUS_RETURN_LEVEL,
    torque: protocol1::register::TORQUE_ENABLE,
    reads: &[(
        protocol1::register::RETURN_DELAY,
        protocol1::register::TORQUE_ENABLE + 1 - protocol1::register::RETURN_DELAY,
    )],
};

/// What is read of an X servo, beginning with what every model has.
const X_READS: [(u16, u16); 7] = [
    // Return delay, drive mode and operating mode are neighbours.
    (protocol2::register::RETURN_DELAY, 3),
    (protocol2::register::TORQUE_ENABLE, 1),
    (protocol2::register::STATUS_RETURN_LEVEL, 1),
    (protocol2::register::BUS_WATCHDOG, 1),
    (protocol2::register::GOAL_PWM, 2),
    (protocol2::register::CURRENT_LIMIT, 2),
    (protocol2::register::GOAL_CURRENT, 2),
];
/// Number of reads before those of models that measure their current.
const X_READS_OF_ALL: usize = 5;

/// In PWM control mode.
const X_PWM: Registers = Registers {
    return_delay: protocol2::register::RETURN_DELAY,
    ready_delay: (protocol2::RETURN_DELAY_US / 2) as u8,
    // With the direction of rotation as it was found, and without torque by a goal.
    mode: protocol2::register::DRIVE_MODE,
    mode_bytes: 2,
    ready_mode: [0, OperatingMode::Pwm.code(), 0, 0],
    kept: [!protocol2::register::TORQUE_BY_GOAL, 0, 0, 0],
    level: protocol2::register::STATUS_RETURN_LEVEL,
    torque: protocol2::register::TORQUE_ENABLE,
    reads: X_READS.split_at(X_READS_OF_ALL).0,
};

/// In current control mode.
const X_CURRENT: Registers = Registers {
    ready_mode: [0, OperatingMode::Current.code(), 0, 0],
    reads: &X_READS,
    ..X_PWM
};

impl Registers {
    /// Those of a firmware; Morpheus needs no set-up.
    pub(super) fn of(firmware: Firmware, mode: ControlMode) -> Option<&'static Self> {
        match (firmware, mode) {
            (Firmware::Morpheus, _) => None,
            (Firmware::Stock, _) => Some(&AX12A),
            (Firmware::XSeries, ControlMode::Pwm) => Some(&X_PWM),
            (Firmware::XSeries, ControlMode::Current) => Some(&X_CURRENT),
        }
    }

    /// Whether an image has room for what is read.
    const fn reads_fit(&self) -> bool {
        let (mut bytes, mut read) = (0, 0);
        while read < self.reads.len() {
            bytes += self.reads[read].1 as usize;
            read += 1;
        }
        bytes <= IMAGE_BYTES
    }

    /// What selects open-loop control, of a servo that was found with `mode`.
    fn made_ready(&self, mode: [u8; 4]) -> [u8; 4] {
        core::array::from_fn(|byte| self.ready_mode[byte] | (mode[byte] & self.kept[byte]))
    }
}

/// What is read of a servo: first addresses and numbers of bytes.
pub(super) type Reads = &'static [(u16, u16)];

/// Registers of one servo as they are read piece by piece, one read after the other.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RegisterImage([u8; IMAGE_BYTES]);

impl RegisterImage {
    /// Takes the data of one of these reads.
    pub(super) fn store(&mut self, reads: Reads, read: u8, data: &[u8]) {
        let before = reads.iter().take(usize::from(read));
        let start = before.map(|(_, count)| usize::from(*count)).sum();
        let after = self.0.get_mut(start..);
        if let Some(bytes) = after.and_then(|bytes| bytes.get_mut(..data.len())) {
            bytes.copy_from_slice(data);
        }
    }

    /// The bytes from this address on, if it has been read.
    #[inline(never)]
    fn from(&self, reads: Reads, address: u16) -> Option<&[u8]> {
        let mut start = 0;
        for (first, count) in reads {
            if (*first..first + count).contains(&address) {
                return self.0.get(start + usize::from(address - first)..);
            }
            start += usize::from(*count);
        }
        None
    }
}

/// Settings of a servo that the bridge changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ServoSettings {
    firmware: Firmware,
    pub(super) return_delay: u8,
    /// Angle limits, or drive mode and operating mode.
    pub(super) mode: [u8; 4],
    /// Torque limit at power-up of a stock servo.
    pub(super) max_torque: [u8; 2],
    /// Status return level.
    pub(super) level: u8,
    /// Torque enable, which is no setting.
    torque: u8,
    /// The watchdog of an X servo, and its goal if it was read, which are none either.
    watchdog: u8,
    goal: Option<[u8; 2]>,
    /// Largest current; 0 unless it was read, in current control mode.
    current_limit: u16,
}

impl ServoSettings {
    /// Decodes the registers, once these reads are over.
    #[inline(never)]
    pub(super) fn decode(
        firmware: Firmware,
        image: &RegisterImage,
        reads: Reads,
        required: XRequirements,
    ) -> Option<Self> {
        let registers = Registers::of(firmware, required.mode)?;
        let from = |address| image.from(reads, address);
        let byte = |address: u16| from(address)?.first().copied();
        let short = |address: u16| from(address)?.first_chunk().copied();
        let mut mode = [0; 4];
        let bytes = from(registers.mode)?.get(..registers.mode_bytes)?;
        mode.get_mut(..registers.mode_bytes)?.copy_from_slice(bytes);
        let is_stock = firmware == Firmware::Stock;
        Some(Self {
            firmware,
            return_delay: byte(registers.return_delay)?,
            mode,
            max_torque: if is_stock {
                short(protocol1::register::MAX_TORQUE)?
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
            goal: match (firmware, required.mode) {
                (Firmware::Morpheus | Firmware::Stock, _) => Some([0; 2]),
                (_, ControlMode::Pwm) => short(protocol2::register::GOAL_PWM),
                (_, ControlMode::Current) => short(protocol2::register::GOAL_CURRENT),
            },
            current_limit: short(protocol2::register::CURRENT_LIMIT).map_or(0, u16::from_le_bytes),
        })
    }

    /// These settings as they are in a servo that takes torque.
    pub(super) fn made_ready(self, required: XRequirements) -> Option<Self> {
        let registers = Registers::of(self.firmware, required.mode)?;
        Some(Self {
            return_delay: registers.ready_delay,
            mode: registers.made_ready(self.mode),
            level: self.level.max(LEVEL_READ),
            ..self
        })
    }

    /// Whether the servo takes torque with these settings.
    pub(super) fn are_ready(self, required: XRequirements) -> bool {
        Registers::of(self.firmware, required.mode).is_some_and(|registers| {
            self.return_delay == registers.ready_delay
                && self.mode == registers.made_ready(self.mode)
                && self.level > 0
        })
    }

    /// Whether torque can be enabled without a motion.
    pub(super) fn are_safe(self, required: XRequirements) -> bool {
        self.are_ready(required) && self.meet(required) && self.goal == Some([0; 2])
    }

    /// Whether it would obey a torque now.
    pub(super) fn are_in_force(self, required: XRequirements) -> bool {
        self.are_ready(required) && self.torque == 1 && self.meet(required)
    }

    /// Whether its watchdog, if it has one, is set, and its current limit permits all commands.
    fn meet(self, required: XRequirements) -> bool {
        self.firmware != Firmware::XSeries
            || (self.watchdog == required.watchdog && self.current_limit >= required.current_max)
    }
}
