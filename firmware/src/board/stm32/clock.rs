//! Time since boot, and the tick's alarm, on a timer of 32 bits at 1 MHz.
//!
//! TIM2 and TIM5 have 32 bits (section 18.1). The timer runs freely through all of them, once
//! in 71.6 minutes, and is extended to 64 bits at every reading, which the tick takes care of
//! a thousand times a second. So time needs no interrupt, cannot miss one, and goes on
//! while the core waits for the flash to be erased: an overflow that is counted by an interrupt
//! is lost or seen late there. It never goes back: a reading adds to the last one.
//!
//! The alarm is compare register 1. It is replaced by the next, so that none fires late:
//! a match of an old one is cleared when the new one is written.

use core::cell::Cell;
use critical_section::Mutex;
use embassy_stm32::pac::timer::TimGp32;

/// Compare register of the alarm: the first.
const ALARM: usize = 0;

/// The clock; one for each timer.
pub struct Clock {
    timer: TimGp32,
    /// The counter as last read, and the µs counted until then.
    counted: Mutex<Cell<(u32, u64)>>,
}

impl Clock {
    /// A clock at 0 on this timer, TIM2 or TIM5, which nothing else uses.
    pub const fn new(timer: TimGp32) -> Self {
        Self {
            timer,
            counted: Mutex::new(Cell::new((0, 0))),
        }
    }

    /// Starts the clock. The timer's own clock is on and of `clock_mhz`; timers on APB1 run at
    /// twice its frequency if that is divided (section 7.2).
    pub fn start(&self, clock_mhz: u16) {
        self.timer.psc().write_value(clock_mhz.saturating_sub(1));
        self.timer.arr().write_value(u32::MAX);
        // The prescaler takes effect at an update, which also clears the counter and sets its
        // flag (section 18.4.6).
        self.timer.egr().write(|w| w.set_ug(true));
        self.timer.sr().write(|w| w.0 = 0);
        self.timer.dier().write(|w| w.set_ccie(ALARM, true));
        self.timer.cr1().write(|w| w.set_cen(true));
    }

    /// Time since [`start`](Self::start) in µs.
    pub fn now_us(&self) -> u64 {
        self.read().1
    }

    /// Time in µs since the last reading, which in the tick is that of its poll.
    pub fn since_read_us(&self) -> u32 {
        self.timer.cnt().read().wrapping_sub(self.last().0)
    }

    /// The counter as last read, and the time then.
    fn last(&self) -> (u32, u64) {
        critical_section::with(|cs| self.counted.borrow(cs).get())
    }

    /// The counter, and the time.
    fn read(&self) -> (u32, u64) {
        critical_section::with(|cs| {
            let counted = self.counted.borrow(cs);
            let (last, total) = counted.get();
            let count = self.timer.cnt().read();
            let now = (count, total + u64::from(count.wrapping_sub(last)));
            counted.set(now);
            now
        })
    }

    /// Sets the alarm, in place of the one before: to this time, but `longest_us` from the last
    /// reading at the most. False if that has come: there may be no interrupt for it.
    pub fn set_alarm(&self, at_us: u64, longest_us: u32) -> bool {
        let (count, now_us) = self.last();
        let wait_us = u32::try_from(at_us.saturating_sub(now_us));
        let wait_us = wait_us.unwrap_or(u32::MAX).min(longest_us);
        // Without preload the value is in force at once (section 18.3.8).
        let at = count.wrapping_add(wait_us);
        self.timer.ccr(ALARM).write_value(at);
        self.clear_alarm();
        // A match sets the flag in the cycle in which the counter reaches the value; one
        // that came before the flag was cleared is detected here.
        self.timer.cnt().read().wrapping_sub(count) < wait_us
    }

    /// Clears the interrupt of the alarm.
    pub fn clear_alarm(&self) {
        // Flags are cleared by 0, and left by 1 (section 18.4.5).
        self.timer.sr().write(|w| {
            w.0 = u32::MAX;
            w.set_ccif(ALARM, false);
        });
    }
}
