//! Time on the board: an integer that divides by the period of every clock in use.
//!
//! A unit is 1/5,040 µs. The periods of 8, 12, 16, 42, 45, 48, 84, 90, 168 and 180 MHz and
//! of 32 kHz are whole numbers of units, so that clocks that are derived from each other
//! never drift apart by rounding.

use std::ops::{Add, AddAssign, Sub};

/// Units of a microsecond: the least common multiple of the clocks in MHz.
const UNITS_PER_US: u64 = 5_040;

/// A time since power-up, or a duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Time(u64);

impl Time {
    /// Power-up.
    pub const ZERO: Self = Self(0);
    /// Later than every event.
    pub const NEVER: Self = Self(u64::MAX);

    /// `us` microseconds.
    pub const fn from_us(us: u64) -> Self {
        Self(us.saturating_mul(UNITS_PER_US))
    }

    /// `ns` nanoseconds, rounded up.
    pub const fn from_ns(ns: u64) -> Self {
        // 5,040 / 1,000 = 126 / 25.
        Self(ns.saturating_mul(126).div_ceil(25))
    }

    /// Periods of a clock of `hz`, which are 0 where the clock stands.
    pub const fn periods(count: u64, hz: u32) -> Self {
        if hz == 0 {
            return Self::NEVER;
        }
        Self(count.saturating_mul(period(hz)))
    }

    /// This duration, `count` times.
    #[must_use]
    pub const fn times(self, count: u64) -> Self {
        Self(self.0.saturating_mul(count))
    }

    /// Whole periods of a clock of `hz` in this duration.
    pub const fn count(self, hz: u32) -> u64 {
        if hz == 0 { 0 } else { self.0 / period(hz) }
    }

    /// In nanoseconds, rounded down.
    pub const fn as_ns(self) -> u64 {
        if self.0 == u64::MAX {
            return u64::MAX;
        }
        (self.0 as u128 * 25 / 126) as u64
    }

    /// In microseconds, rounded down.
    pub const fn as_us(self) -> u64 {
        self.0 / UNITS_PER_US
    }

    /// In milliseconds.
    pub fn as_ms(self) -> f64 {
        self.0 as f64 / (1_000.0 * UNITS_PER_US as f64)
    }

    /// The difference, or nothing if `other` is later.
    #[must_use]
    pub const fn since(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

/// Units of a period of a clock of `hz`, to the nearest.
const fn period(hz: u32) -> u64 {
    let hz = hz as u64;
    let period = (UNITS_PER_US * 1_000_000 + hz / 2) / hz;
    if period == 0 { 1 } else { period }
}

impl Add for Time {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign for Time {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Time {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.since(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_of_the_chip_have_whole_periods() {
        for mhz in [8_u32, 12, 16, 42, 45, 48, 84, 90, 168, 180] {
            assert_eq!(UNITS_PER_US % u64::from(mhz), 0, "{mhz} MHz");
            assert_eq!(
                Time::periods(u64::from(mhz), mhz * 1_000_000),
                Time::from_us(1)
            );
        }
        assert_eq!(Time::periods(32, 32_000), Time::from_us(1_000));
        assert_eq!(Time::from_us(3).count(168_000_000), 504);
        for ns in [1, 5, 999, 1_000, 123_456_789] {
            assert_eq!(Time::from_ns(ns).as_ns(), ns);
        }
    }
}
