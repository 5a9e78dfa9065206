//! The tick and the board for it: alarm, stopwatch and stop switch.
//!
//! The tick runs in the handler of a software interrupt, which alarm, bus, client and bench make
//! pending.
//!
//! TIMER1 is the alarm while the real-time loop waits, and its stopwatch while it
//! decides. The stopwatch starts on a whole cycle, so that the same instructions always
//! take the same time with `-icount`.
//!
//! In lockstep the alarm does not matter: the next grant wakes the real-time loop (see
//! [`super::lockstep`]).

use super::bus::BusLine;
use super::interrupt::Irq;
use super::supply::SupplyPin;
use super::timer::TIMER1;
use super::{BUS, CLOCK_MHZ, clock, fault_injection, watchdog};
use crate::handler_cell::HandlerCell;
use crate::tasks::{RealTime, RealTimeLoop, Wait};
use armbridge_link::message::StopSource;
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::NVIC;
use critical_section::Mutex;

/// In lockstep: end of the wait of the real-time loop, in µs, and the number of bytes
/// that ends it earlier.
static WAITS_FOR: Mutex<Cell<(u64, Option<u16>)>> = Mutex::new(Cell::new((0, None)));
/// In lockstep: state of the stop switch, from the bench.
static STOP_PRESSED: AtomicBool = AtomicBool::new(false);
/// The tick of this board.
pub type Tick = RealTimeLoop<'static, BusLine, Board, SupplyPin>;

static TICK: HandlerCell<Tick> = HandlerCell::new();

/// Starts the tick, which runs at once.
pub fn start_tick(tick: Tick) {
    TICK.put(tick);
    wake();
    // SAFETY: the handler is in place and its state too, and no critical section relies on
    // priorities.
    unsafe { NVIC::unmask(Irq::Tick) };
}

/// Lets the tick run as soon as priorities permit.
pub fn wake() {
    NVIC::pend(Irq::Tick);
    // The interrupt is taken here, if it can be, and not some instructions later.
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// The tick's interrupt handler.
pub fn on_tick() {
    if let Some(wait) = TICK.with(RealTimeLoop::run) {
        wait_for(wait);
    }
}

/// Sets the alarm and the number of bytes that start the tick again.
fn wait_for(Wait { until_us, bytes }: Wait) {
    let now_us = clock::now_us();
    if clock::is_lockstep() {
        let bytes = bytes.and_then(|wanted| u16::try_from(wanted).ok());
        critical_section::with(|cs| WAITS_FOR.borrow(cs).set((until_us, bytes)));
        return;
    }
    let us = until_us.saturating_sub(now_us);
    if us == 0 || BUS.buffers().wake_after(bytes) {
        wake();
        return;
    }
    TIMER1.stop();
    // Waking early, after 171 s, does no harm.
    let cycles = u32::try_from(us.saturating_mul(u64::from(clock::cycles_per_us())));
    TIMER1.interrupt_after(cycles.unwrap_or(u32::MAX));
}

/// In lockstep: end of the wait of the real-time loop, in µs, and the number of bytes
/// that ends it earlier.
pub fn waits_for() -> (u64, Option<u16>) {
    critical_section::with(|cs| WAITS_FOR.borrow(cs).get())
}

/// In lockstep: sets the time and the stop switch, and lets the real-time loop run.
pub fn grant(now_us: u64, is_stop_pressed: bool) {
    STOP_PRESSED.store(is_stop_pressed, Ordering::Relaxed);
    clock::grant(now_us);
    wake();
}

/// Handles received bytes in the bus's RX interrupt. In lockstep bytes count only once they
/// are granted.
pub fn on_bus_activity() {
    if BUS.buffers().is_due() && !clock::is_lockstep() {
        wake();
    }
}

/// The alarm interrupt's handler.
pub fn on_alarm() {
    TIMER1.stop();
    wake();
}

/// The board for the real-time loop.
#[derive(Debug)]
pub struct Board;

impl RealTime for Board {
    fn now_us(&self) -> u64 {
        clock::now_us()
    }

    /// Replaces the alarm, which is no longer needed; the next one is set after the tick.
    fn start_stopwatch(&mut self) {
        TIMER1.stop();
        TIMER1.count();
    }

    fn stopwatch_ns(&self) -> u32 {
        const CYCLE_NS: u32 = 1000 / CLOCK_MHZ;
        TIMER1.elapsed().saturating_mul(CYCLE_NS)
    }

    fn note_good_tick(&mut self) {
        watchdog::feed();
    }

    /// The switch of the bench, in place of a pin. Injected failures happen
    /// here, because the real-time loop calls this in each iteration.
    fn stop_source(&mut self) -> Option<StopSource> {
        fault_injection::if_due(clock::now_us());
        STOP_PRESSED
            .load(Ordering::Relaxed)
            .then_some(StopSource::Pin)
    }
}
