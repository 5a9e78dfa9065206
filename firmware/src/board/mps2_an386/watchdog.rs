//! The watchdog: CMSDK APB watchdog, at 25 MHz.
//!
//! Its first expiry is a non-maskable interrupt, which finds out where the program
//! hangs and ends it (see [`crate::crash`]); a second one, a period later, resets the
//! machine. It counts QEMU's time, so a QEMU that the host keeps waiting may be
//! bitten without fault of its own; in slow motion its period is longer by as
//! much, like everything else.
//!
//! It stays off in lockstep: time stands still there while QEMU waits for its
//! bench, and the bench sees by itself that a board no longer answers.

use super::clock;
use crate::crash::WATCHDOG_US;
use core::ptr;

const BASE: usize = 0x4000_8000;

/// Offsets of the registers, from the CMSDK technical reference manual.
mod register {
    /// The counter begins here, counts down, and then again.
    pub(super) const LOAD: usize = 0x0;
    pub(super) const CONTROL: usize = 0x8;
    /// Any value written ends the interrupt, and the counter begins again.
    pub(super) const INT_CLEAR: usize = 0xC;
}

const CONTROL_INTERRUPT: u32 = 1 << 0;
const CONTROL_RESET: u32 = 1 << 1;

/// Starts it.
pub fn start() {
    // Beyond 1,600 times slower, it is a period of 171 s.
    let cycles = WATCHDOG_US.saturating_mul(clock::cycles_per_us());
    write(register::LOAD, cycles);
    write(register::CONTROL, CONTROL_INTERRUPT | CONTROL_RESET);
}

/// All is well; without effect if it is off.
pub fn feed() {
    write(register::INT_CLEAR, 1);
}

fn write(offset: usize, value: u32) {
    // SAFETY: `offset` is that of one of the watchdog's registers, 32 bits wide; it
    // never touches memory.
    unsafe { ptr::write_volatile((BASE + offset) as *mut u32, value) }
}
