//! What the emulator adds to how the program ends, and begins again.

use super::bus::PolledBus;
use super::semihosting::{self, EXIT_FAULT, EXIT_PANIC};
use super::{clock, watchdog};
use crate::crash::memory;
use armbridge_shared::link::message::End;
use cortex_m::peripheral::SCB;

/// The servo bus, by polling, whatever state it is in.
pub(crate) fn polled_bus() -> PolledBus {
    PolledBus::take()
}

/// Cause of the reset, which the machine does not report. If memory was kept, it was
/// QEMU's monitor or the watchdog's second expiry; otherwise QEMU has just begun.
pub fn reset_cause() -> End {
    if memory::is_kept() {
        End::ResetPin
    } else {
        End::PowerUp
    }
}

/// One period more for ending.
pub(crate) fn feed_watchdog() {
    watchdog::feed();
}

/// Resets the machine; in lockstep leaves QEMU, because the bench could not
/// follow.
pub(crate) fn reset(cause: End) -> ! {
    if clock::is_lockstep() {
        let is_panic = cause == End::Panic;
        semihosting::exit(if is_panic { EXIT_PANIC } else { EXIT_FAULT });
    }
    SCB::sys_reset()
}
