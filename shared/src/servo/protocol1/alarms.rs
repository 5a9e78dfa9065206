//! The error byte of a status packet.

use core::fmt;

/// What a servo complains of. Several at once are usual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Hash)]
pub struct Alarms(u8);

/// Names, from bit 0 on (e-Manual, "Error").
const NAMES: [&str; 7] = [
    "input voltage",
    "angle limit",
    "overheating",
    "range",
    "checksum",
    "overload",
    "instruction",
];

impl Alarms {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// Supply outside the voltage limits.
    pub const INPUT_VOLTAGE: Self = Self(1 << 0);
    /// A goal outside the angle limits.
    pub const ANGLE_LIMIT: Self = Self(1 << 1);
    /// Hotter than the temperature limit.
    pub const OVERHEATING: Self = Self(1 << 2);
    /// A value outside its register's range, or an address outside the table.
    pub const RANGE: Self = Self(1 << 3);
    /// An instruction packet with a wrong checksum.
    pub const CHECKSUM: Self = Self(1 << 4);
    /// The load cannot be held at the torque limit.
    pub const OVERLOAD: Self = Self(1 << 5);
    /// An unknown instruction, or ACTION with nothing registered.
    pub const INSTRUCTION: Self = Self(1 << 6);

    /// From the error byte. Bit 7 has no meaning and is dropped.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0x7F)
    }

    /// The error byte.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether there are none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether all of these are among them.
    pub const fn contains(self, alarms: Self) -> bool {
        self.0 & alarms.0 == alarms.0
    }

    /// Those that are in both.
    #[must_use]
    pub const fn and(self, alarms: Self) -> Self {
        Self(self.0 & alarms.0)
    }

    /// Those that are in either.
    #[must_use]
    pub const fn or(self, alarms: Self) -> Self {
        Self(self.0 | alarms.0)
    }

    /// The one of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        let bit = NAMES.iter().position(|known| *known == name)?;
        Some(Self(1 << bit))
    }

    /// Their names, from bit 0 on.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let Self(bits) = self;
        NAMES
            .into_iter()
            .enumerate()
            .filter_map(move |(bit, name)| (bits & (1 << bit) != 0).then_some(name))
    }
}

impl fmt::Display for Alarms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        for (i, name) in self.names().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            f.write_str(name)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_bit_has_its_name() {
        let alarms = Alarms::OVERLOAD.or(Alarms::OVERHEATING);
        assert_eq!(alarms.bits(), 36);
        assert_eq!(alarms.to_string(), "overheating, overload");
        assert_eq!(Alarms::from_bits(0xFF).names().count(), 7);
        assert_eq!(Alarms::from_bits(0x80).to_string(), "none");
        assert_eq!(Alarms::from_bits(64).to_string(), "instruction");
    }
}
