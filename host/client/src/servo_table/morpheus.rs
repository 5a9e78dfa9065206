//! The Morpheus firmware V1.2: its source, `Eprom.h` and `Morpheus.c`.
//!
//! Eighteen bytes, of which the first eleven are EEPROM. Reading has traps: a
//! read that begins in the EEPROM never reaches the RAM, and one whose first
//! byte happens to be 0x83 blocks the receivers of the other servos
//! ([`armbridge_servo::morpheus`]).

use super::Access::{Read, ReadWrite};
use super::Size::{Byte, Word};
use super::Storage::{Eeprom, Ram};
use super::{Table, Unit, row};

/// Registers of a servo that runs Morpheus.
#[rustfmt::skip]
pub const MORPHEUS: Table = Table {
    size: 18,
    registers: &[
        // Any value but 0xAA here makes the servo lose all its settings.
        row(0x00, Byte, "magic",           Read,      Eeprom, 0xAA..=0xAA, Some(0xAA), Unit::Number),
        row(0x01, Byte, "id",              ReadWrite, Eeprom, 1..=253,     Some(1),    Unit::Number),
        row(0x02, Byte, "upper_margin",    ReadWrite, Eeprom, 0..=255,     Some(2),    Unit::Counts),
        row(0x03, Byte, "lower_margin",    ReadWrite, Eeprom, 0..=255,     Some(2),    Unit::Counts),
        row(0x04, Byte, "position_kp",     ReadWrite, Eeprom, 0..=255,     Some(40),   Unit::Number),
        row(0x05, Byte, "position_ki",     ReadWrite, Eeprom, 0..=255,     Some(1),    Unit::Number),
        row(0x06, Byte, "position_kd",     ReadWrite, Eeprom, 0..=255,     Some(10),   Unit::Number),
        row(0x07, Byte, "speed_kp",        ReadWrite, Eeprom, 0..=255,     Some(40),   Unit::Number),
        row(0x08, Byte, "speed_ki",        ReadWrite, Eeprom, 0..=255,     Some(10),   Unit::Number),
        row(0x09, Byte, "speed_kd",        ReadWrite, Eeprom, 0..=255,     Some(0),    Unit::Number),
        row(0x0A, Byte, "baud_rate",       ReadWrite, Eeprom, 0..=207,     Some(1),    Unit::Baud),
        // Read: present position. Written: goal.
        row(0x0B, Word, "position",        ReadWrite, Ram,    0..=1023,    None,       Unit::Counts),
        // Read: counts in 14 samples, without sign, low byte only.
        row(0x0D, Byte, "speed",           ReadWrite, Ram,    0..=255,     None,       Unit::Number),
        row(0x0E, Word, "temperature",     Read,      Ram,    0..=1023,    None,       Unit::Counts),
        // Read back, the high byte is always 0.
        row(0x10, Word, "pwm",             ReadWrite, Ram,    0..=2000,    Some(1000), Unit::Pwm),
    ],
};
