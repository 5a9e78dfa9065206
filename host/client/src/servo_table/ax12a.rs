//! The stock AX-12A: ROBOTIS e-Manual, "AX-12A", control table. Where today's
//! page and the manual of 2006 differ, today's.

use super::Access::{Read, ReadWrite};
use super::Size::{Byte, Word};
use super::Storage::{Eeprom, Ram};
use super::{Table, Unit, row};

/// Registers of a stock AX-12A.
#[rustfmt::skip]
pub const AX12A: Table = Table {
    size: 50,
    registers: &[
        row( 0, Word, "model_number",          Read,      Eeprom, 0..=65535, Some(12),   Unit::Number),
        row( 2, Byte, "firmware_version",      Read,      Eeprom, 0..=255,   None,       Unit::Number),
        row( 3, Byte, "id",                    ReadWrite, Eeprom, 0..=253,   Some(1),    Unit::Number),
        row( 4, Byte, "baud_rate",             ReadWrite, Eeprom, 0..=254,   Some(1),    Unit::Baud),
        row( 5, Byte, "return_delay_time",     ReadWrite, Eeprom, 0..=254,   Some(250),  Unit::TwoMicroseconds),
        row( 6, Word, "cw_angle_limit",        ReadWrite, Eeprom, 0..=1023,  Some(0),    Unit::Angle),
        row( 8, Word, "ccw_angle_limit",       ReadWrite, Eeprom, 0..=1023,  Some(1023), Unit::Angle),
        row(11, Byte, "temperature_limit",     ReadWrite, Eeprom, 0..=99,    Some(70),   Unit::Celsius),
        row(12, Byte, "min_voltage_limit",     ReadWrite, Eeprom, 50..=160,  Some(60),   Unit::DeciVolt),
        row(13, Byte, "max_voltage_limit",     ReadWrite, Eeprom, 50..=160,  Some(140),  Unit::DeciVolt),
        row(14, Word, "max_torque",            ReadWrite, Eeprom, 0..=1023,  Some(1023), Unit::PerMille),
        row(16, Byte, "status_return_level",   ReadWrite, Eeprom, 0..=2,     Some(2),    Unit::Number),
        row(17, Byte, "alarm_led",             ReadWrite, Eeprom, 0..=127,   Some(36),   Unit::Alarms),
        row(18, Byte, "shutdown",              ReadWrite, Eeprom, 0..=127,   Some(36),   Unit::Alarms),
        row(24, Byte, "torque_enable",         ReadWrite, Ram,    0..=1,     Some(0),    Unit::Number),
        row(25, Byte, "led",                   ReadWrite, Ram,    0..=1,     Some(0),    Unit::Number),
        row(26, Byte, "cw_compliance_margin",  ReadWrite, Ram,    0..=255,   Some(1),    Unit::Angle),
        row(27, Byte, "ccw_compliance_margin", ReadWrite, Ram,    0..=255,   Some(1),    Unit::Angle),
        row(28, Byte, "cw_compliance_slope",   ReadWrite, Ram,    0..=254,   Some(32),   Unit::Number),
        row(29, Byte, "ccw_compliance_slope",  ReadWrite, Ram,    0..=254,   Some(32),   Unit::Number),
        row(30, Word, "goal_position",         ReadWrite, Ram,    0..=1023,  None,       Unit::Angle),
        row(32, Word, "moving_speed",          ReadWrite, Ram,    0..=2047,  None,       Unit::SignedPerMille),
        row(34, Word, "torque_limit",          ReadWrite, Ram,    0..=1023,  None,       Unit::PerMille),
        row(36, Word, "present_position",      Read,      Ram,    0..=1023,  None,       Unit::Angle),
        row(38, Word, "present_speed",         Read,      Ram,    0..=2047,  None,       Unit::SignedSpeed),
        row(40, Word, "present_load",          Read,      Ram,    0..=2047,  None,       Unit::SignedPerMille),
        row(42, Byte, "present_voltage",       Read,      Ram,    0..=255,   None,       Unit::DeciVolt),
        row(43, Byte, "present_temperature",   Read,      Ram,    0..=255,   None,       Unit::Celsius),
        row(44, Byte, "registered",            Read,      Ram,    0..=1,     Some(0),    Unit::Number),
        row(46, Byte, "moving",                Read,      Ram,    0..=1,     Some(0),    Unit::Number),
        row(47, Byte, "lock",                  ReadWrite, Ram,    0..=1,     Some(0),    Unit::Number),
        row(48, Word, "punch",                 ReadWrite, Ram,    32..=1023, Some(32),   Unit::PerMille),
    ],
};
