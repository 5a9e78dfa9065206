//! The watchdog: CMSDK APB watchdog, at 25 MHz.
//!
//! Its first expiry is a non-maskable interrupt, which records where the program
//! hangs and ends it (see [`crate::crash`]); a second one, a period later, resets the
//! machine. It counts QEMU's time, so it may expire in a QEMU that the host delays; in slow
//! motion its period is longer by the same factor.
//!
//! It stays off in lockstep: time does not advance there while QEMU waits for its
//! bench, and the bench itself detects a board that no longer answers.

use super::clock;
use crate::crash::WATCHDOG_US;
use core::ptr;

const BASE: usize = 0x4000_8000;

/// Offsets of the registers, from the CMSDK technical reference manual.
mod register {
    /// Start value of the counter, which counts down and reloads.
    pub(super) const LOAD: usize = 0x0;
    pub(super) const CONTROL: usize = 0x8;
    /// Any write clears the interrupt, and reloads the counter.
    pub(super) const INT_CLEAR: usize = 0xC;
}

const CONTROL_INTERRUPT: u32 = 1 << 0;
const CONTROL_RESET: u32 = 1 << 1;

/// Starts the watchdog.
pub fn start() {
    // Beyond 1,600 times slower, it is a period of 171 s.
    let cycles = WATCHDOG_US.saturating_mul(clock::cycles_per_us());
    write(register::LOAD, cycles);
    write(register::CONTROL, CONTROL_INTERRUPT | CONTROL_RESET);
}

/// Feeds the watchdog; without effect if it is off.
pub fn feed() {
    write(register::INT_CLEAR, 1);
}

fn write(offset: usize, value: u32) {
    // SAFETY: `offset` is that of one of the watchdog's registers, 32 bits wide; it
    // never touches memory.
    unsafe { ptr::write_volatile((BASE + offset) as *mut u32, value) }
}
