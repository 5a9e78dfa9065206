//! Independent watchdog (section 21): counts down on its own oscillator, which no program
//! can stop, and resets the chip at zero.

use crate::time::Time;

/// Frequency of the low-speed oscillator: nominal; from 17 to 47 kHz in fact (data sheet,
/// table 35).
pub const NOMINAL_HZ: u32 = 32_000;

/// The watchdog.
#[derive(Clone, Debug)]
pub struct Iwdg {
    /// Its oscillator.
    pub lsi_hz: u32,
    prescaler: u32,
    reload: u32,
    is_unlocked: bool,
    /// When it bites, once started.
    bites_at: Option<Time>,
    fed_at: Time,
    longest_gap: Time,
}

impl Iwdg {
    /// Stopped, as after a reset.
    pub fn new(lsi_hz: u32) -> Self {
        Self {
            lsi_hz,
            prescaler: 0,
            reload: 0xFFF,
            is_unlocked: false,
            bites_at: None,
            fed_at: Time::ZERO,
            longest_gap: Time::ZERO,
        }
    }

    /// Reads a register. An update of PR and RLR takes no time here.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x0 | 0xC => Some(0),
            0x4 => Some(self.prescaler),
            0x8 => Some(self.reload),
            _ => None,
        }
    }

    /// Writes a register; `None` if there is none.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x0 => match value & 0xFFFF {
                0x5555 => self.is_unlocked = true,
                0xAAAA => {
                    self.is_unlocked = false;
                    if self.bites_at.is_some() {
                        self.longest_gap = self.longest_gap.max(now - self.fed_at);
                        self.feed(now);
                    }
                }
                0xCCCC => {
                    self.is_unlocked = false;
                    self.feed(now);
                }
                _ => self.is_unlocked = false,
            },
            0x4 if self.is_unlocked => self.prescaler = value & 7,
            0x8 if self.is_unlocked => self.reload = value & 0xFFF,
            0x4 | 0x8 => {}
            _ => return None,
        }
        Some(())
    }

    fn feed(&mut self, now: Time) {
        self.fed_at = now;
        self.bites_at = Some(now + self.period());
    }

    /// Time from a feeding to the bite (table 107).
    pub fn period(&self) -> Time {
        let divider = (4_u64 << self.prescaler).min(256);
        Time::periods(divider * u64::from(self.reload + 1), self.lsi_hz)
    }

    /// Whether it runs.
    pub fn is_running(&self) -> bool {
        self.bites_at.is_some()
    }

    /// Longest time between two feedings so far.
    pub fn longest_gap(&self) -> Time {
        self.longest_gap
    }

    /// Time of its next bite.
    pub fn next(&self) -> Time {
        self.bites_at.unwrap_or(Time::NEVER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_bites_unless_it_is_fed() {
        let mut dog = Iwdg::new(NOMINAL_HZ);
        let mut write = |at_us, offset, value| dog.write(Time::from_us(at_us), offset, value);
        // Locked registers stay.
        assert_eq!(write(0, 0x8, 1), Some(()));
        for (offset, value) in [(0x0, 0x5555), (0x4, 1), (0x8, 399), (0x0, 0xCCCC)] {
            assert_eq!(write(0, offset, value), Some(()));
        }
        assert_eq!(write(30_000, 0x0, 0xAAAA), Some(()));
        assert_eq!(dog.read(0x8), Some(399));
        // 8 * 400 / 32 kHz.
        assert_eq!(dog.next(), Time::from_us(130_000));
        assert_eq!(dog.longest_gap(), Time::from_us(30_000));
    }
}
