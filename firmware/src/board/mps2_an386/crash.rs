//! Crash handling of the emulator: reset cause, watchdog, reset.

use super::bus::PolledBus;
use super::semihosting::{self, EXIT_FAULT, EXIT_PANIC};
use super::supply::SupplyPin;
use super::{clock, watchdog};
use crate::crash::memory;
use armbridge_link::message::End;
use cortex_m::peripheral::SCB;

/// Cause of the non-maskable interrupt: the watchdog, a whole period before it resets.
pub(crate) const NMI: End = End::Watchdog;

/// Switches the servos' supply off, from any state.
pub(crate) fn cut_supply() {
    SupplyPin::take();
}

/// The servo bus for polling, from any state.
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

/// Feeds the watchdog, for one more period.
pub(crate) fn feed_watchdog() {
    watchdog::feed();
}

/// Resets the machine; in lockstep leaves QEMU, because the bench cannot
/// continue after a reset.
pub(crate) fn reset(cause: End) -> ! {
    if clock::is_lockstep() {
        let is_panic = cause == End::Panic;
        semihosting::exit(if is_panic { EXIT_PANIC } else { EXIT_FAULT });
    }
    SCB::sys_reset()
}
