//! General-purpose timers (sections 18 and 19): prescaler, up-counter, four compare
//! channels, update and compare flags. Capture, PWM outputs and slave modes are not modelled.

use crate::time::Time;

const CR1_CEN: u32 = 1;
const CR1_URS: u32 = 1 << 2;
const CR1_OPM: u32 = 1 << 3;
const UPDATE: u32 = 1;

/// A timer.
#[derive(Clone, Debug)]
pub struct Timer {
    /// Largest count: of 16 or of 32 bits.
    most: u32,
    /// Clock before the prescaler, in Hz.
    clock_hz: u32,
    control: [u32; 2],
    slave: u32,
    enabled: u32,
    flags: u32,
    modes: [u32; 3],
    /// Prescaler as written, and in force since the last update.
    prescaler: [u32; 2],
    reload: u32,
    compare: [u32; 4],
    dma: [u32; 2],
    options: u32,
    /// The count at `since`, from which it runs.
    count: u32,
    since: Time,
    started: Option<Time>,
}

impl Timer {
    /// A stopped timer of 16 or 32 bits.
    pub fn new(bits: u32) -> Self {
        let most = u32::MAX >> (32 - bits);
        Self {
            most,
            clock_hz: 0,
            control: [0; 2],
            slave: 0,
            enabled: 0,
            flags: 0,
            modes: [0; 3],
            prescaler: [0; 2],
            reload: most,
            compare: [0; 4],
            dma: [0; 2],
            options: 0,
            count: 0,
            since: Time::ZERO,
            started: None,
        }
    }

    /// Sets its clock, from `now` on.
    pub fn set_clock(&mut self, now: Time, hz: u32) {
        if hz != self.clock_hz {
            self.advance(now);
            self.clock_hz = hz;
        }
    }

    fn is_running(&self) -> bool {
        self.control[0] & CR1_CEN != 0 && self.clock_hz != 0
    }

    /// Duration of a count.
    fn step(&self) -> u64 {
        u64::from(self.prescaler[1]) + 1
    }

    /// Counts from one update to the next.
    fn cycle(&self) -> u64 {
        u64::from(self.reload) + 1
    }

    /// Counts up to `now`, and raises the flags of what was passed.
    pub fn advance(&mut self, now: Time) {
        if !self.is_running() {
            self.since = now;
            return;
        }
        let steps = (now - self.since).count(self.clock_hz) / self.step();
        if steps == 0 {
            return;
        }
        self.since += Time::periods(steps * self.step(), self.clock_hz);
        let begin = u64::from(self.count);
        let end = begin + steps;
        let cycle = self.cycle();
        if end >= cycle {
            self.flags |= UPDATE;
            self.prescaler[1] = self.prescaler[0];
            if self.control[0] & CR1_OPM != 0 {
                self.control[0] &= !CR1_CEN;
            }
        }
        for (channel, compare) in self.compare.iter().enumerate() {
            // The count becomes the compare value at `begin + ahead`.
            let ahead = (u64::from(*compare) + cycle - begin % cycle - 1) % cycle + 1;
            if u64::from(*compare) < cycle && ahead <= steps {
                self.flags |= 2 << channel;
            }
        }
        self.count = (end % cycle) as u32;
    }

    /// When it was started last.
    pub fn started(&self) -> Option<Time> {
        self.started
    }

    /// Whether its interrupt line is high.
    pub fn is_interrupt(&self) -> bool {
        self.flags & self.enabled & 0x1F != 0
    }

    /// The time at which it raises an interrupt by itself, or later.
    pub fn next(&self) -> Time {
        if !self.is_running() {
            return Time::NEVER;
        }
        let cycle = self.cycle();
        let begin = u64::from(self.count) % cycle;
        let channels = self.compare.iter().enumerate();
        let compares = channels
            .filter(|(channel, compare)| {
                self.enabled & !self.flags & 2 << channel != 0 && u64::from(**compare) < cycle
            })
            .map(|(_, compare)| (u64::from(*compare) + cycle - begin - 1) % cycle + 1);
        let update = (self.enabled & !self.flags & UPDATE != 0).then(|| cycle - begin);
        match compares.chain(update).min() {
            Some(steps) => self.since + Time::periods(steps * self.step(), self.clock_hz),
            None => Time::NEVER,
        }
    }

    /// Reads a register.
    pub fn read(&mut self, now: Time, offset: u32) -> Option<u32> {
        self.advance(now);
        Some(match offset {
            0x00 | 0x04 => self.control[offset as usize / 4],
            0x08 => self.slave,
            0x0C => self.enabled,
            0x10 => self.flags,
            0x14 => 0,
            0x18..=0x20 => self.modes[(offset as usize - 0x18) / 4],
            0x24 => self.count,
            0x28 => self.prescaler[0],
            0x2C => self.reload,
            0x34..=0x40 => self.compare[(offset as usize - 0x34) / 4],
            0x48 | 0x4C => self.dma[(offset as usize - 0x48) / 4],
            0x50 => self.options,
            _ => return None,
        })
    }

    /// Writes a register; `None` if there is none. Reload and compare values take effect at
    /// once, as without preload.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Option<()> {
        self.advance(now);
        match offset {
            0x00 => {
                let was_running = self.is_running();
                self.control[0] = value;
                if !was_running {
                    self.since = now;
                    self.started = Some(now);
                }
            }
            0x04 => self.control[1] = value,
            0x08 => self.slave = value,
            0x0C => self.enabled = value,
            // Flags are cleared by writing 0.
            0x10 => self.flags &= value,
            0x14 => {
                if value & 1 != 0 {
                    self.count = 0;
                    self.since = now;
                    self.prescaler[1] = self.prescaler[0];
                    if self.control[0] & CR1_URS == 0 {
                        self.flags |= UPDATE;
                    }
                }
                self.flags |= value & 0x1E;
            }
            0x18..=0x20 => self.modes[(offset as usize - 0x18) / 4] = value,
            0x24 => self.count = value & self.most,
            0x28 => self.prescaler[0] = value & 0xFFFF,
            0x2C => self.reload = value & self.most,
            0x34..=0x40 => self.compare[(offset as usize - 0x34) / 4] = value & self.most,
            0x48 | 0x4C => self.dma[(offset as usize - 0x48) / 4] = value,
            0x50 => self.options = value,
            _ => return None,
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A timer of 32 bits at 1 MHz from 84 MHz, started at 0.
    fn started() -> Timer {
        let mut timer = Timer::new(32);
        timer.set_clock(Time::ZERO, 84_000_000);
        for (offset, value) in [(0x28, 83), (0x14, 1), (0x10, 0), (0x00, 1)] {
            assert_eq!(timer.write(Time::ZERO, offset, value), Some(()));
        }
        timer
    }

    #[test]
    fn a_compare_is_raised_when_the_count_is_reached() {
        let mut timer = started();
        let at = Time::from_us;
        assert_eq!(timer.write(at(10), 0x34, 25), Some(()));
        assert_eq!(timer.write(at(10), 0x0C, 2), Some(()));
        assert_eq!(timer.next(), at(25));
        timer.advance(at(24));
        assert!(!timer.is_interrupt());
        timer.advance(at(25));
        assert!(timer.is_interrupt());
        // A compare value of the present count is a cycle away.
        assert_eq!(timer.write(at(25), 0x10, 0), Some(()));
        assert!(timer.next() > at(1_000_000_000));
        assert_eq!(timer.read(at(70), 0x24), Some(70));
    }

    #[test]
    fn a_timer_of_16_bits_wraps_with_an_update() {
        let mut timer = Timer::new(16);
        timer.set_clock(Time::ZERO, 1_000_000);
        assert_eq!(timer.write(Time::ZERO, 0x0C, 1), Some(()));
        assert_eq!(timer.write(Time::ZERO, 0x00, 1), Some(()));
        assert_eq!(timer.next(), Time::from_us(65_536));
        assert_eq!(timer.read(Time::from_us(65_540), 0x24), Some(4));
        assert!(timer.is_interrupt());
    }
}
