//! What reading or writing a register comes to.

use std::ops::RangeInclusive;

use super::master::BusError;
use crate::servo_table::Register;

/// What a register holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// This.
    Known(u16),
    /// A number with this low byte; the servo does not tell the high one.
    LowByte(u8),
}

/// A register and what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Which.
    pub register: &'static Register,
    /// What.
    pub value: Value,
}

/// How sure it is that a value was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// It was read back.
    ReadBack,
    /// Its low byte was read back, and that is all there is.
    LowByteReadBack,
    /// The register reads something else than was written.
    NotReadable,
}

/// Why a register could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ServoError {
    /// No usable answer.
    #[error("servo {id}: {error}")]
    Bus {
        /// Of whom.
        id: u8,
        /// Why.
        error: BusError,
    },
    /// Two servos have the id.
    #[error(
        "two servos have id {0}, one with each firmware: take one off the bus and give the \
         other another id"
    )]
    TwoFirmwares(u8),
    /// A stock servo answers PING and not READ.
    #[error(
        "servo {0} answers PING and not READ: its status_return_level is likely 0; write 2 to it"
    )]
    Mute(u8),
    /// Not to be written.
    #[error("{name} can only be read")]
    ReadOnly {
        /// Its name.
        name: &'static str,
    },
    /// Not to be written like any other.
    #[error("{name} is changed by `{command}`, which checks that the servo is found again")]
    OtherCommand {
        /// Its name.
        name: &'static str,
        /// What changes it.
        command: &'static str,
    },
    /// Outside its range.
    #[error("{name} is from {} to {}, not {value}", range.start(), range.end())]
    OutOfRange {
        /// The register's name.
        name: &'static str,
        /// What was to be written.
        value: u16,
        /// What can be.
        range: RangeInclusive<u16>,
    },
    /// The servo took something else.
    #[error("servo {id} was to keep {wanted} in {name}, but keeps {kept}")]
    Kept {
        /// Which servo.
        id: u8,
        /// The register's name.
        name: &'static str,
        /// What was written.
        wanted: u16,
        /// What is read.
        kept: u16,
    },
    /// A stock servo's EEPROM takes nothing now.
    #[error("servo {id} does not take {name}: {why}")]
    Closed {
        /// Which servo.
        id: u8,
        /// The register's name.
        name: &'static str,
        /// What closes it.
        why: Closed,
    },
    /// It may have been written.
    #[error("{name} was written to servo {id}, but cannot be read back: {error}")]
    NotReadBack {
        /// Which servo.
        id: u8,
        /// The register's name.
        name: &'static str,
        /// Why.
        error: Box<ServoError>,
    },
}

impl ServoError {
    /// Whether it is the servo's doing, or the bus's, rather than that of the
    /// port or of whoever asked.
    pub fn is_of_the_servo(&self) -> bool {
        match self {
            Self::Bus { error, .. } => matches!(error, BusError::Diagnosis(_)),
            Self::NotReadBack { error, .. } => error.is_of_the_servo(),
            Self::TwoFirmwares(_) | Self::Mute(_) | Self::Kept { .. } | Self::Closed { .. } => true,
            Self::ReadOnly { .. } | Self::OtherCommand { .. } | Self::OutOfRange { .. } => false,
        }
    }
}

/// What closes the EEPROM of a stock servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Closed {
    /// Torque is on.
    #[error("its EEPROM is closed while torque is on; write 0 to torque_enable first")]
    Torque,
    /// Somebody locked it.
    #[error("its EEPROM is locked until it is switched off (lock is 1)")]
    Lock,
}
