//! Results of reading and writing a register.

use std::ops::RangeInclusive;

use super::master::BusError;
use crate::servo_table::Register;

/// Value of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// The whole value.
    Known(u32),
    /// A number with this low byte; the servo does not send the high one.
    LowByte(u8),
}

/// A register and its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// The register.
    pub register: &'static Register,
    /// Its value.
    pub value: Value,
}

/// Confirmation of a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// It was read back.
    ReadBack,
    /// Its low byte was read back; the servo sends no more.
    LowByteReadBack,
    /// The register reads as another quantity than it is written.
    NotReadable,
}

/// Reason for which a register could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ServoError {
    /// No usable answer.
    #[error("servo {id}: {error}")]
    Bus {
        /// Id of the servo.
        id: u8,
        /// Error of the exchange.
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
    /// The register is read-only.
    #[error("{name} can only be read")]
    ReadOnly {
        /// Its name.
        name: &'static str,
    },
    /// The register has a command of its own.
    #[error("{name} is changed by `{command}`, which checks that the servo is found again")]
    OtherCommand {
        /// Its name.
        name: &'static str,
        /// That command.
        command: &'static str,
    },
    /// Outside its range.
    #[error("{name} is from {} to {}, not {value}", range.start(), range.end())]
    OutOfRange {
        /// The register's name.
        name: &'static str,
        /// Requested value.
        value: u32,
        /// Permitted values.
        range: RangeInclusive<u32>,
    },
    /// The servo stored another value.
    #[error("servo {id} was to keep {wanted} in {name}, but keeps {stored}")]
    StoredOther {
        /// Id of the servo.
        id: u8,
        /// The register's name.
        name: &'static str,
        /// Written value.
        wanted: u32,
        /// Value read back.
        stored: u32,
    },
    /// A stock servo's EEPROM is closed.
    #[error("servo {id} does not take {name}: {why}")]
    Closed {
        /// Id of the servo.
        id: u8,
        /// The register's name.
        name: &'static str,
        /// Reason.
        why: Closed,
    },
    /// The write is not confirmed.
    #[error("{name} was written to servo {id}, but cannot be read back: {error}")]
    NotReadBack {
        /// Id of the servo.
        id: u8,
        /// The register's name.
        name: &'static str,
        /// Error of reading back.
        error: Box<ServoError>,
    },
}

impl ServoError {
    /// Whether the cause is the servo or the bus, rather than the
    /// port or the request.
    pub fn is_servo_error(&self) -> bool {
        match self {
            Self::Bus { error, .. } => matches!(error, BusError::Diagnosis(_)),
            Self::NotReadBack { error, .. } => error.is_servo_error(),
            Self::TwoFirmwares(_)
            | Self::Mute(_)
            | Self::StoredOther { .. }
            | Self::Closed { .. } => true,
            Self::ReadOnly { .. } | Self::OtherCommand { .. } | Self::OutOfRange { .. } => false,
        }
    }
}

/// Reason for which the EEPROM of a stock servo is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Closed {
    /// Torque is on.
    #[error("its EEPROM is closed while torque is on; write 0 to torque_enable first")]
    Torque,
    /// It is locked.
    #[error("its EEPROM is locked until it is switched off (lock is 1)")]
    Lock,
}
