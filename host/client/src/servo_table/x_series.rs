//! The X series: ROBOTIS e-Manual, control tables of XL430-W250, XL330-M288, XC330-T288 and
//! XM430-W350, as far as they agree. Where models differ, the range is that of the widest.

use super::Access::{Read, ReadWrite};
use super::Size::{Byte, Long, Word};
use super::Storage::{Eeprom, Ram};
use super::{Table, Unit, row};

/// Any number of four bytes.
const ANY: core::ops::RangeInclusive<u32> = 0..=u32::MAX;

/// Registers of an X servo.
#[rustfmt::skip]
pub const X_SERIES: Table = Table {
    size: 147,
    registers: &[
        row(  0, Word, "model_number",           Read,      Eeprom, 0..=65535, None,       Unit::Number),
        row(  2, Long, "model_information",      Read,      Eeprom, ANY,       None,       Unit::Number),
        row(  6, Byte, "firmware_version",       Read,      Eeprom, 0..=255,   None,       Unit::Number),
        row(  7, Byte, "id",                     ReadWrite, Eeprom, 0..=252,   Some(1),    Unit::Number),
        row(  8, Byte, "baud_rate",              ReadWrite, Eeprom, 0..=7,     Some(1),    Unit::BaudCode),
        row(  9, Byte, "return_delay_time",      ReadWrite, Eeprom, 0..=254,   Some(250),  Unit::TwoMicroseconds),
        row( 10, Byte, "drive_mode",             ReadWrite, Eeprom, 0..=13,    Some(0),    Unit::Number),
        row( 11, Byte, "operating_mode",         ReadWrite, Eeprom, 0..=16,    Some(3),    Unit::Number),
        row( 12, Byte, "secondary_id",           ReadWrite, Eeprom, 0..=255,   Some(255),  Unit::Number),
        row( 20, Long, "homing_offset",          ReadWrite, Eeprom, ANY,       Some(0),    Unit::Turns),
        row( 24, Long, "moving_threshold",       ReadWrite, Eeprom, 0..=1023,  Some(10),   Unit::Speed),
        row( 31, Byte, "temperature_limit",      ReadWrite, Eeprom, 0..=100,   None,       Unit::Celsius),
        row( 32, Word, "max_voltage_limit",      ReadWrite, Eeprom, 31..=160,  None,       Unit::DeciVolt),
        row( 34, Word, "min_voltage_limit",      ReadWrite, Eeprom, 31..=160,  None,       Unit::DeciVolt),
        row( 36, Word, "pwm_limit",              ReadWrite, Eeprom, 0..=885,   Some(885),  Unit::Duty),
        row( 38, Word, "current_limit",          ReadWrite, Eeprom, 0..=2047,  None,       Unit::Number),
        row( 44, Long, "velocity_limit",         ReadWrite, Eeprom, 0..=2047,  None,       Unit::Speed),
        row( 48, Long, "max_position_limit",     ReadWrite, Eeprom, 0..=4095,  Some(4095), Unit::Turns),
        row( 52, Long, "min_position_limit",     ReadWrite, Eeprom, 0..=4095,  Some(0),    Unit::Turns),
        row( 63, Byte, "shutdown",               ReadWrite, Eeprom, 0..=63,    None,       Unit::Number),
        row( 64, Byte, "torque_enable",          ReadWrite, Ram,    0..=1,     Some(0),    Unit::Number),
        row( 65, Byte, "led",                    ReadWrite, Ram,    0..=1,     Some(0),    Unit::Number),
        row( 68, Byte, "status_return_level",    ReadWrite, Ram,    0..=2,     Some(2),    Unit::Number),
        row( 69, Byte, "registered_instruction", Read,      Ram,    0..=1,     Some(0),    Unit::Number),
        row( 70, Byte, "hardware_error_status",  Read,      Ram,    0..=255,   Some(0),    Unit::Number),
        row( 76, Word, "velocity_i_gain",        ReadWrite, Ram,    0..=16383, None,       Unit::Number),
        row( 78, Word, "velocity_p_gain",        ReadWrite, Ram,    0..=16383, None,       Unit::Number),
        row( 80, Word, "position_d_gain",        ReadWrite, Ram,    0..=16383, None,       Unit::Number),
        row( 82, Word, "position_i_gain",        ReadWrite, Ram,    0..=16383, None,       Unit::Number),
        row( 84, Word, "position_p_gain",        ReadWrite, Ram,    0..=16383, None,       Unit::Number),
        row( 88, Word, "feedforward_2nd_gain",   ReadWrite, Ram,    0..=16383, Some(0),    Unit::Number),
        row( 90, Word, "feedforward_1st_gain",   ReadWrite, Ram,    0..=16383, Some(0),    Unit::Number),
        row( 98, Byte, "bus_watchdog",           ReadWrite, Ram,    0..=127,   Some(0),    Unit::TwentyMilliseconds),
        row(100, Word, "goal_pwm",               ReadWrite, Ram,    0..=65535, None,       Unit::Duty),
        row(102, Word, "goal_current",           ReadWrite, Ram,    0..=65535, None,       Unit::Signed),
        row(104, Long, "goal_velocity",          ReadWrite, Ram,    ANY,       None,       Unit::Speed),
        row(108, Long, "profile_acceleration",   ReadWrite, Ram,    0..=32767, Some(0),    Unit::Number),
        row(112, Long, "profile_velocity",       ReadWrite, Ram,    0..=32767, Some(0),    Unit::Number),
        row(116, Long, "goal_position",          ReadWrite, Ram,    ANY,       None,       Unit::Turns),
        row(120, Word, "realtime_tick",          Read,      Ram,    0..=32767, None,       Unit::Number),
        row(122, Byte, "moving",                 Read,      Ram,    0..=1,     Some(0),    Unit::Number),
        row(123, Byte, "moving_status",          Read,      Ram,    0..=255,   None,       Unit::Number),
        row(124, Word, "present_pwm",            Read,      Ram,    0..=65535, None,       Unit::Duty),
        row(126, Word, "present_current",        Read,      Ram,    0..=65535, None,       Unit::Signed),
        row(128, Long, "present_velocity",       Read,      Ram,    ANY,       None,       Unit::Speed),
        row(132, Long, "present_position",       Read,      Ram,    ANY,       None,       Unit::Turns),
        row(136, Long, "velocity_trajectory",    Read,      Ram,    ANY,       None,       Unit::Speed),
        row(140, Long, "position_trajectory",    Read,      Ram,    ANY,       None,       Unit::Turns),
        row(144, Word, "present_input_voltage",  Read,      Ram,    0..=65535, None,       Unit::DeciVolt),
        row(146, Byte, "present_temperature",    Read,      Ram,    0..=255,   None,       Unit::Celsius),
    ],
};
