//! Time: real, or granted by the bench.
//!
//! TIMER0 runs through all 2³² values of a 25 MHz counter, once in 171 s; it is
//! extended to 64 bits at every reading, so it has to be read more often than
//! that, which the tick does. TIMER1 is the alarm while the real-time loop
//! waits, and its stopwatch while it decides. The stopwatch starts on a whole
//! cycle, so that the same instructions always take the same time with
//! `-icount`.
//!
//! In lockstep neither matters: the time is that of the last grant, and the
//! real-time loop is woken by the next one (see [`super::lockstep`]).

use super::{BUS, CLOCK_MHZ, bus, fault_injection, watchdog};
use crate::tasks::RealTime;
use core::cell::Cell;
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use critical_section::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

const TIMER0: usize = 0x4000_0000;
const TIMER1: usize = 0x4000_1000;

/// Offsets of the registers, from the CMSDK technical reference manual. The
/// counters count down and start again from RELOAD.
mod register {
    pub(super) const CTRL: usize = 0x0;
    pub(super) const VALUE: usize = 0x4;
    pub(super) const RELOAD: usize = 0x8;
    pub(super) const INT_CLEAR: usize = 0xC;
}

const CTRL_ENABLE: u32 = 1 << 0;
const CTRL_INTERRUPT: u32 = 1 << 3;

/// The counter as last read, and the cycles counted until then.
static COUNTED: Mutex<Cell<(u32, u64)>> = Mutex::new(Cell::new((0, 0)));
/// In lockstep: the time in µs.
static GRANTED: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));
/// In lockstep: until when the real-time loop waits, in µs, and for how many
/// bytes.
static WAITS_FOR: Mutex<Cell<(u64, Option<u16>)>> = Mutex::new(Cell::new((0, None)));
static LOCKSTEP: AtomicBool = AtomicBool::new(false);
/// In lockstep: the stop switch, as the bench has it.
static STOP_PRESSED: AtomicBool = AtomicBool::new(false);
/// Wakes the real-time loop.
static WAKE: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Cycles of the 25 MHz counter per µs of the board's time: more than 25 in slow
/// motion.
static CYCLES_PER_US: AtomicU32 = AtomicU32::new(CLOCK_MHZ);

/// Starts the clock at 0; in `lockstep` it stands until the first grant,
/// otherwise it runs `slow` times slower than QEMU's.
pub fn start(lockstep: bool, slow: u32) {
    CYCLES_PER_US.store(CLOCK_MHZ.saturating_mul(slow.max(1)), Ordering::Relaxed);
    count();
    LOCKSTEP.store(lockstep, Ordering::Relaxed);
}

/// Lets the counter of cycles run, if it does not.
pub fn count() {
    if read(TIMER0, register::CTRL) & CTRL_ENABLE == 0 {
        write(TIMER0, register::RELOAD, u32::MAX);
        write(TIMER0, register::VALUE, u32::MAX);
        write(TIMER0, register::CTRL, CTRL_ENABLE);
    }
}

/// Whether the bench grants the time.
pub fn is_lockstep() -> bool {
    LOCKSTEP.load(Ordering::Relaxed)
}

/// Cycles, modulo 2³².
pub fn cycles() -> u32 {
    u32::MAX - read(TIMER0, register::VALUE)
}

/// Cycles of that counter in a µs of the board's time.
pub fn cycles_per_us() -> u32 {
    CYCLES_PER_US.load(Ordering::Relaxed).max(1)
}

/// Time since boot in µs.
pub fn now_us() -> u64 {
    critical_section::with(|cs| {
        if LOCKSTEP.load(Ordering::Relaxed) {
            return GRANTED.borrow(cs).get();
        }
        let (last, total) = COUNTED.borrow(cs).get();
        let cycles = cycles();
        let total = total + u64::from(cycles.wrapping_sub(last));
        COUNTED.borrow(cs).set((cycles, total));
        total / u64::from(cycles_per_us())
    })
}

/// In lockstep: until when the real-time loop waits, in µs, and how many bytes
/// end its wait before that.
pub fn waits_for() -> (u64, Option<u16>) {
    critical_section::with(|cs| WAITS_FOR.borrow(cs).get())
}

/// In lockstep: sets the time and the stop switch, and lets the real-time loop run.
pub fn grant(now_us: u64, is_stop_pressed: bool) {
    STOP_PRESSED.store(is_stop_pressed, Ordering::Relaxed);
    critical_section::with(|cs| {
        let granted = GRANTED.borrow(cs);
        // Time never goes back, whatever the grant.
        granted.set(granted.get().max(now_us));
    });
    WAKE.signal(());
}

/// From the handler of the bus's RX interrupt: bytes are there. In lockstep they
/// count only once they are granted.
pub fn on_bus_activity() {
    if BUS.buffers().is_due() && !LOCKSTEP.load(Ordering::Relaxed) {
        WAKE.signal(());
    }
}

/// The client has sent bytes.
pub fn wake() {
    WAKE.signal(());
}

/// The alarm interrupt's handler.
pub fn on_alarm() {
    stop_alarm();
    WAKE.signal(());
}

fn stop_alarm() {
    write(TIMER1, register::CTRL, 0);
    write(TIMER1, register::INT_CLEAR, 1);
}

/// The board as the real-time loop sees it.
#[derive(Debug)]
pub struct Board;

impl RealTime for Board {
    fn now_us(&self) -> u64 {
        now_us()
    }

    /// Whatever alarm is set has done its work; `wait` sets the next one.
    fn start_stopwatch(&mut self) {
        stop_alarm();
        write(TIMER1, register::RELOAD, u32::MAX);
        write(TIMER1, register::CTRL, CTRL_ENABLE);
    }

    fn stopwatch_ns(&self) -> u32 {
        const CYCLE_NS: u32 = 1000 / CLOCK_MHZ;
        (u32::MAX - read(TIMER1, register::VALUE)).saturating_mul(CYCLE_NS)
    }

    async fn wait(&mut self, until_us: u64, bytes_wanted: Option<usize>) {
        let now_us = now_us();
        // The end of a transmission counts as bus activity.
        let until_us = bus::sent_at_us(now_us).map_or(until_us, |sent_us| sent_us.min(until_us));
        if LOCKSTEP.load(Ordering::Relaxed) {
            let bytes = bytes_wanted.and_then(|wanted| u16::try_from(wanted).ok());
            critical_section::with(|cs| WAITS_FOR.borrow(cs).set((until_us, bytes)));
        } else {
            let us = until_us.saturating_sub(now_us);
            if us == 0 || BUS.buffers().expect(bytes_wanted) {
                return;
            }
            stop_alarm();
            // Waking early, after 171 s, does no harm.
            let cycles = u32::try_from(us.saturating_mul(u64::from(cycles_per_us())));
            write(TIMER1, register::RELOAD, cycles.unwrap_or(u32::MAX));
            write(TIMER1, register::CTRL, CTRL_ENABLE | CTRL_INTERRUPT);
        }
        WAKE.wait().await;
    }

    fn tick_was_good(&mut self) {
        watchdog::feed();
    }

    /// There is no pin: only the bench can press it. Provoked failures happen
    /// here, because the real-time loop comes here in each of its turns.
    fn is_stop_pressed(&mut self) -> bool {
        fault_injection::if_due(now_us());
        STOP_PRESSED.load(Ordering::Relaxed)
    }
}

fn read(timer: usize, offset: usize) -> u32 {
    // SAFETY: `timer` is the base of a timer of this machine and `offset` that
    // of one of its registers, 32 bits wide. Reading has no effect on memory.
    unsafe { ptr::read_volatile((timer + offset) as *const u32) }
}

fn write(timer: usize, offset: usize, value: u32) {
    // SAFETY: as for reading; a timer never touches memory.
    unsafe { ptr::write_volatile((timer + offset) as *mut u32, value) }
}
