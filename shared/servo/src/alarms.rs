//! The error byte of a status packet of Protocol 1.0, and what an X servo has in its place.

/// Alarms of a servo. Several at once are usual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Hash)]
pub struct Alarms(u8);

impl Alarms {
    /// No alarm.
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

    /// Of an X servo: one of its hardware errors. Which, is in its register.
    pub const HARDWARE: Self = Self(1 << 7);

    /// Decodes the error byte, of which Protocol 1.0 has seven bits.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// The error byte.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether there is no alarm.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether all of `alarms` are set.
    pub const fn contains(self, alarms: Self) -> bool {
        self.0 & alarms.0 == alarms.0
    }

    /// Alarms that are in both.
    #[must_use]
    pub const fn and(self, alarms: Self) -> Self {
        Self(self.0 & alarms.0)
    }

    /// Alarms that are in either.
    #[must_use]
    pub const fn or(self, alarms: Self) -> Self {
        Self(self.0 | alarms.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_has_a_meaning() {
        let alarms = Alarms::OVERLOAD.or(Alarms::OVERHEATING);
        assert_eq!(alarms.bits(), 36);
        assert!(alarms.contains(Alarms::OVERLOAD) && !alarms.contains(Alarms::RANGE));
        assert_eq!(Alarms::from_bits(0x80), Alarms::HARDWARE);
    }
}
