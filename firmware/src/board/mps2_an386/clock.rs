//! Clock: real time, or the time of the bench's last grant.
//!
//! TIMER0 runs through all 2³² values of a 25 MHz counter, once in 171 s; it is
//! extended to 64 bits at every reading, so it has to be read more often than
//! that, which the tick does. In lockstep the time is that of the last grant (see
//! [`super::lockstep`]).

use super::CLOCK_MHZ;
use super::timer::TIMER0;
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use critical_section::Mutex;

/// The counter as last read, and the cycles counted until then.
static COUNTED: Mutex<Cell<(u32, u64)>> = Mutex::new(Cell::new((0, 0)));
/// In lockstep: the time in µs.
static GRANTED: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));
static LOCKSTEP: AtomicBool = AtomicBool::new(false);
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

/// Starts the counter of cycles, unless it runs.
pub fn count() {
    if !TIMER0.is_running() {
        TIMER0.count();
    }
}

/// Whether the bench grants the time.
pub fn is_lockstep() -> bool {
    LOCKSTEP.load(Ordering::Relaxed)
}

/// Cycles, modulo 2³².
pub fn cycles() -> u32 {
    TIMER0.elapsed()
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

/// In lockstep: sets the time.
pub fn grant(now_us: u64) {
    critical_section::with(|cs| {
        let granted = GRANTED.borrow(cs);
        // Time never goes back, whatever the grant.
        granted.set(granted.get().max(now_us));
    });
}
