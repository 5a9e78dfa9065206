//! Registers of servos by name: one table per firmware, both in the same form, and
//! the names of alarms.
//!
//! A register has one, two or four bytes, low byte first. Values here are raw, as on the wire;
//! [`Unit`] gives their meaning. Where a number of an AX-12A is sign and magnitude, bit 10 is the
//! sign; numbers of the X series are two's complement.
//!
//! The board has addresses and sizes only; a test here compares them.

pub mod alarms;
mod ax12a;
mod morpheus;
mod x_series;

use armbridge_servo::protocol2::model;
use armbridge_servo::{Alarms, Firmware};
pub use ax12a::AX12A;
pub use morpheus::MORPHEUS;
pub use x_series::X_SERIES;

use core::fmt;
use core::ops::RangeInclusive;

/// Registers of one firmware, in the order of their addresses.
#[derive(Debug, PartialEq, Eq)]
pub struct Table {
    /// Bytes from address 0 to the last, gaps included.
    pub size: u16,
    /// In the order of their addresses, without overlap.
    pub registers: &'static [Register],
}

/// One register.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Register {
    /// Address of its (low) byte.
    pub address: u16,
    /// Number of its bytes.
    pub size: Size,
    /// In snake case, as on the command line.
    pub name: &'static str,
    /// Whether it can be written.
    pub access: Access,
    /// Memory that holds it.
    pub storage: Storage,
    /// Values that may be written, or are read.
    pub range: RangeInclusive<u32>,
    /// Ex works, or at power-up, if known.
    pub initial: Option<u32>,
    /// Meaning of the number.
    pub unit: Unit,
}

/// Bytes of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// One.
    Byte,
    /// Two, low byte first.
    Word,
    /// Four, low byte first.
    Long,
}

impl Size {
    /// As a number.
    pub const fn bytes(self) -> u16 {
        match self {
            Self::Byte => 1,
            Self::Word => 2,
            Self::Long => 4,
        }
    }

    /// The number whose two's complement has these bytes.
    pub const fn complement(self, raw: u32) -> i32 {
        match self {
            Self::Byte => raw as u8 as i8 as i32,
            Self::Word => raw as u16 as i16 as i32,
            Self::Long => raw as i32,
        }
    }
}

/// Whether a register can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Only read.
    Read,
    /// Read and written.
    ReadWrite,
}

/// Memory of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Survives power-off; limited number of writes.
    Eeprom,
    /// Returns to its initial value at power-up.
    Ram,
}

/// Meaning of a raw value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A number, a flag or a code.
    Number,
    /// Baud rate of 2 000 000 / (value + 1).
    Baud,
    /// 2 µs.
    TwoMicroseconds,
    /// 1/1023 of 300°: 0.29°.
    Angle,
    /// °C.
    Celsius,
    /// 0.1 V.
    DeciVolt,
    /// 0.1 % of the maximum.
    PerMille,
    /// 0.1 %, with bit 10 for clockwise.
    SignedPerMille,
    /// 0.111 rpm, with bit 10 for clockwise.
    SignedSpeed,
    /// One bit for each of [`Alarms`].
    Alarms,
    /// Counts of the servo's converter, not calibrated.
    Counts,
    /// 0.1 % of full voltage either side of 1000, which is off.
    Pwm,
    /// Code of a baud rate of the X series.
    BaudCode,
    /// A number in two's complement.
    Signed,
    /// 1/4096 of a turn, in two's complement.
    Turns,
    /// 1/885 of the supply, in two's complement.
    Duty,
    /// 0.229 rpm, in two's complement.
    Speed,
    /// 20 ms; 255 once it has run out.
    TwentyMilliseconds,
}

impl Table {
    /// The registers of a servo with this firmware.
    pub const fn for_firmware(firmware: Firmware) -> &'static Self {
        match firmware {
            Firmware::Morpheus => &MORPHEUS,
            Firmware::Stock => &AX12A,
            Firmware::XSeries => &X_SERIES,
        }
    }

    /// The register of this name.
    pub fn by_name(&self, name: &str) -> Option<&'static Register> {
        self.registers
            .iter()
            .find(|register| register.name.eq_ignore_ascii_case(name))
    }

    /// The register whose first byte is at this address.
    pub fn at(&self, address: u16) -> Option<&'static Register> {
        self.registers
            .iter()
            .find(|register| register.address == address)
    }
}

impl Register {
    /// The address after its last byte.
    pub const fn end(&self) -> u16 {
        self.address + self.size.bytes()
    }

    /// Its value in a copy of the servo's memory from address `from` on.
    pub fn value_in(&self, memory: &[u8], from: u16) -> Option<u32> {
        let start = usize::from(self.address.checked_sub(from)?);
        let bytes = memory.get(start..start + usize::from(self.size.bytes()))?;
        Some(
            bytes
                .iter()
                .rev()
                .fold(0, |value, byte| value << 8 | u32::from(*byte)),
        )
    }

    /// Its bytes on the wire; the low one alone if it has only one.
    pub fn bytes_of(&self, value: u32) -> Vec<u8> {
        let bytes = value.to_le_bytes();
        bytes.into_iter().take(self.size.bytes().into()).collect()
    }

    /// Its value as text, with the unit.
    pub const fn show(&self, value: u32) -> Shown {
        Shown {
            unit: self.unit,
            size: self.size,
            value,
        }
    }
}

/// A row of a table.
#[expect(clippy::too_many_arguments, reason = "a row of a table")]
const fn row(
    address: u16,
    size: Size,
    name: &'static str,
    access: Access,
    storage: Storage,
    range: RangeInclusive<u32>,
    initial: Option<u32>,
    unit: Unit,
) -> Register {
    Register {
        address,
        size,
        name,
        access,
        storage,
        range,
        initial,
        unit,
    }
}

/// A raw value with its unit, as text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shown {
    unit: Unit,
    size: Size,
    value: u32,
}

/// Bit 10: clockwise.
const CLOCKWISE: u32 = 1 << 10;

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let raw = self.value;
        let number = f64::from(raw);
        let magnitude = f64::from(raw & (CLOCKWISE - 1));
        let complement = f64::from(self.size.complement(raw));
        let signed = if raw & CLOCKWISE == 0 {
            magnitude
        } else {
            -magnitude
        };
        match self.unit {
            Unit::Number => write!(f, "{raw}"),
            Unit::Baud => write!(f, "{} baud", 2_000_000 / (raw + 1)),
            Unit::TwoMicroseconds => write!(f, "{} us", 2 * raw),
            Unit::Angle => write!(f, "{:.1} deg", number * 300.0 / 1023.0),
            Unit::Celsius => write!(f, "{raw} degC"),
            Unit::DeciVolt => write!(f, "{:.1} V", number / 10.0),
            Unit::PerMille => write!(f, "{:.1} %", number / 10.23),
            Unit::SignedPerMille => write!(f, "{:.1} %", signed / 10.23),
            Unit::SignedSpeed => write!(f, "{:.1} rpm", signed * 0.111),
            Unit::Alarms => f.write_str(&alarms::text(Alarms::from_bits(raw as u8))),
            Unit::Counts => write!(f, "{raw} counts"),
            Unit::Pwm => write!(f, "{:+.1} %", (number - 1000.0) / 10.0),
            Unit::BaudCode => match model::baud_rate(raw as u8) {
                Some(baud) => write!(f, "{baud} baud"),
                None => write!(f, "{raw}"),
            },
            Unit::Signed => write!(f, "{complement}"),
            Unit::Turns => write!(f, "{:.1} deg", complement * 360.0 / 4096.0),
            Unit::Duty => write!(f, "{:+.1} %", complement / 8.85),
            Unit::Speed => write!(f, "{:.1} rpm", complement * 0.229),
            Unit::TwentyMilliseconds if raw == 255 => write!(f, "has run out"),
            Unit::TwentyMilliseconds => write!(f, "{} ms", 20 * raw),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_servo::protocol1::register;

    #[test]
    fn tables_are_in_order_and_in_themselves_consistent() {
        for table in [&AX12A, &MORPHEUS, &X_SERIES] {
            let mut end = 0;
            for register in table.registers {
                assert!(register.address >= end, "{}", register.name);
                end = register.end();
                let largest = match register.size {
                    Size::Byte => 0xFF,
                    Size::Word => 0xFFFF,
                    Size::Long => u32::MAX,
                };
                assert!(*register.range.end() <= largest, "{}", register.name);
                if let Some(initial) = register.initial {
                    assert!(register.range.contains(&initial), "{}", register.name);
                }
                assert_eq!(table.by_name(register.name), Some(register));
            }
            assert_eq!(end, table.size);
        }
    }

    /// Registers in the board's form.
    #[test]
    fn addresses_and_sizes_are_the_boards() {
        for firmware in Firmware::ALL {
            let table = Table::for_firmware(firmware);
            assert_eq!(firmware.memory_bytes(), table.size);
            for address in 0..table.size {
                let has =
                    |register: &&Register| (register.address..register.end()).contains(&address);
                let register = table.registers.iter().find(has);
                let start = register.map_or(address, |register| register.address);
                assert_eq!(firmware.register_start(address), start, "{address}");
            }
        }
        let names = [
            ("id", register::ID),
            ("return_delay_time", register::RETURN_DELAY),
            ("cw_angle_limit", register::ANGLE_LIMITS),
            ("max_torque", register::MAX_TORQUE),
            ("status_return_level", register::STATUS_RETURN_LEVEL),
            ("torque_enable", register::TORQUE_ENABLE),
            ("led", register::LED),
            ("moving_speed", register::MOVING_SPEED),
            ("present_position", register::PRESENT_POSITION),
            ("present_temperature", register::PRESENT_TEMPERATURE),
        ];
        for (name, address) in names {
            assert_eq!(AX12A.by_name(name).unwrap().address, address, "{name}");
        }
        let position = MORPHEUS.by_name("position").unwrap().address;
        assert_eq!(Firmware::Morpheus.unreadable(), Some(position));
    }

    #[test]
    fn values_are_read_low_byte_first_and_shown_with_their_units() {
        let speed = AX12A.by_name("present_speed").unwrap();
        assert_eq!(speed.value_in(&[9, 0x00, 0x06], 37), Some(0x0600));
        assert_eq!(speed.value_in(&[9, 0x00], 37), None);
        let shown = |name, value| AX12A.by_name(name).unwrap().show(value).to_string();
        assert_eq!(shown("present_speed", 0x0400 + 100), "-11.1 rpm");
        assert_eq!(shown("baud_rate", 1), "1000000 baud");
        assert_eq!(shown("present_voltage", 111), "11.1 V");
        assert_eq!(shown("shutdown", 36), "overheating, overload");
    }
}
