//! The board for the real-time loop: alarm, stopwatch and stop switch.
//!
//! TIMER1 is the alarm while the real-time loop waits, and its stopwatch while it
//! decides. The stopwatch starts on a whole cycle, so that the same instructions always
//! take the same time with `-icount`.
//!
//! In lockstep the alarm does not matter: the next grant wakes the real-time loop (see
//! [`super::lockstep`]).

use super::timer::TIMER1;
use super::{BUS, CLOCK_MHZ, bus, clock, fault_injection, watchdog};
use crate::tasks::RealTime;
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// In lockstep: end of the wait of the real-time loop, in µs, and the number of bytes
/// that ends it earlier.
static WAITS_FOR: Mutex<Cell<(u64, Option<u16>)>> = Mutex::new(Cell::new((0, None)));
/// In lockstep: state of the stop switch, from the bench.
static STOP_PRESSED: AtomicBool = AtomicBool::new(false);
/// Wakes the real-time loop.
static WAKE: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// In lockstep: end of the wait of the real-time loop, in µs, and the number of bytes
/// that ends it earlier.
pub fn waits_for() -> (u64, Option<u16>) {
    critical_section::with(|cs| WAITS_FOR.borrow(cs).get())
}

/// In lockstep: sets the time and the stop switch, and lets the real-time loop run.
pub fn grant(now_us: u64, is_stop_pressed: bool) {
    STOP_PRESSED.store(is_stop_pressed, Ordering::Relaxed);
    clock::grant(now_us);
    WAKE.signal(());
}

/// Handles received bytes in the bus's RX interrupt. In lockstep bytes count only once they
/// are granted.
pub fn on_bus_activity() {
    if BUS.buffers().is_due() && !clock::is_lockstep() {
        WAKE.signal(());
    }
}

/// Wakes the real-time loop: the client has sent bytes.
pub fn wake() {
    WAKE.signal(());
}

/// The alarm interrupt's handler.
pub fn on_alarm() {
    TIMER1.stop();
    WAKE.signal(());
}

/// The board for the real-time loop.
#[derive(Debug)]
pub struct Board;

impl RealTime for Board {
    fn now_us(&self) -> u64 {
        clock::now_us()
    }

    /// Replaces the alarm, which is no longer needed; `wait` sets the next one.
    fn start_stopwatch(&mut self) {
        TIMER1.stop();
        TIMER1.count();
    }

    fn stopwatch_ns(&self) -> u32 {
        const CYCLE_NS: u32 = 1000 / CLOCK_MHZ;
        TIMER1.elapsed().saturating_mul(CYCLE_NS)
    }

    async fn wait(&mut self, until_us: u64, bytes_wanted: Option<usize>) {
        let now_us = clock::now_us();
        // The end of a transmission counts as bus activity.
        let until_us = bus::sent_at_us(now_us).map_or(until_us, |sent_us| sent_us.min(until_us));
        if clock::is_lockstep() {
            let bytes = bytes_wanted.and_then(|wanted| u16::try_from(wanted).ok());
            critical_section::with(|cs| WAITS_FOR.borrow(cs).set((until_us, bytes)));
        } else {
            let us = until_us.saturating_sub(now_us);
            if us == 0 || BUS.buffers().expect(bytes_wanted) {
                return;
            }
            TIMER1.stop();
            // Waking early, after 171 s, does no harm.
            let cycles = u32::try_from(us.saturating_mul(u64::from(clock::cycles_per_us())));
            TIMER1.interrupt_after(cycles.unwrap_or(u32::MAX));
        }
        WAKE.wait().await;
    }

    fn note_good_tick(&mut self) {
        watchdog::feed();
    }

    /// The switch of the bench, in place of a pin. Injected failures happen
    /// here, because the real-time loop calls this in each iteration.
    fn is_stop_pressed(&mut self) -> bool {
        fault_injection::if_due(clock::now_us());
        STOP_PRESSED.load(Ordering::Relaxed)
    }
}
