//! Time: embassy's, on TIM2 at 1 MHz; the stopwatch is the cycle counter.

use super::{CORE_MHZ, bus};
use crate::tasks::RealTime;
use cortex_m::peripheral::DWT;
use embassy_futures::select::select;
use embassy_stm32::gpio::Input;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Instant, Timer};

/// Longest interval between polls of the emergency stop, in µs.
pub const STOP_LOOK_US: u64 = 1_000;

/// A transmission ends with an interrupt. Its end as computed comes some µs before it,
/// at which the tick would have nothing to do; this margin wakes the tick
/// only if the interrupt is lost.
const SENT_GRACE_US: u64 = 50;

/// The board for the real-time loop.
pub struct Board {
    stop: Input<'static>,
    watchdog: IndependentWatchdog<'static, IWDG>,
    begun: u32,
}

impl Board {
    /// A board whose watchdog is running, and its cycle counter too. `stop` is
    /// the emergency stop's input, pulled up.
    pub fn new(watchdog: IndependentWatchdog<'static, IWDG>, stop: Input<'static>) -> Self {
        Self {
            stop,
            watchdog,
            begun: 0,
        }
    }
}

/// Time since boot in µs.
pub fn now_us() -> u64 {
    Instant::now().as_micros()
}

impl RealTime for Board {
    fn now_us(&self) -> u64 {
        now_us()
    }

    fn start_stopwatch(&mut self) {
        self.begun = DWT::cycle_count();
    }

    fn stopwatch_ns(&self) -> u32 {
        let cycles = DWT::cycle_count().wrapping_sub(self.begun);
        let ns = u64::from(cycles) * 1000 / u64::from(CORE_MHZ);
        u32::try_from(ns).unwrap_or(u32::MAX)
    }

    async fn wait(&mut self, until_us: u64, bytes_wanted: Option<usize>) {
        if bus::expect(bytes_wanted) {
            return;
        }
        let until_us = if bus::is_sending() {
            until_us.saturating_add(SENT_GRACE_US)
        } else {
            until_us
        };
        let until_us = until_us.min(now_us() + STOP_LOOK_US);
        // In this order: a timer that is polled after the bus has woken the tick
        // would be set once more.
        select(
            bus::ACTIVITY.wait(),
            Timer::at(Instant::from_micros(until_us)),
        )
        .await;
    }

    fn note_good_tick(&mut self) {
        self.watchdog.pet();
    }

    fn is_stop_pressed(&mut self) -> bool {
        self.stop.is_high()
    }
}
