//! Crash handling of the chip: reset cause, watchdog, reset.

use super::polled_bus::PolledBus;
use super::wiring::Wiring;
use super::{bus, watchdog};
use crate::board::Chosen;
use armbridge_link::message::End;
use cortex_m::peripheral::SCB;
use embassy_stm32::interrupt;
use embassy_stm32::pac::RCC;

/// Cause of the non-maskable interrupt: the clock security system.
pub(crate) const NMI: End = End::Crystal;

// A program that the ROM loader started finds clocks and peripherals as the loader left them:
// before memory is initialised, and before any interrupt can be taken from this program's
// vectors, it resets the chip once. The program after that finds all as it must be: SWS in
// RCC_CFGR, the source of the system clock, is 0 then. It is set by the loader, which runs on
// the PLL. Written in assembly because no memory may be used yet.
core::arch::global_asm!(
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "ldr r0, =0x40023808",
    "ldr r0, [r0]",
    "tst r0, #0xC",
    "beq 1f",
    // AIRCR, with its key: SYSRESETREQ.
    "ldr r0, =0xE000ED0C",
    "ldr r1, =0x05FA0004",
    "str r1, [r0]",
    "dsb",
    "2: b 2b",
    "1: bx lr",
    ".ltorg",
);

/// The supply sags: the program ends before the core reads flash wrongly.
#[interrupt]
fn PVD() {
    crate::crash::end(End::BrownOut)
}

/// Switches the servos' supply off, from any state.
pub(crate) fn cut_supply() {
    Chosen::SUPPLY.make_output(false);
}

/// The servo bus for polling, from any state.
pub(crate) fn polled_bus() -> PolledBus<Chosen> {
    bus::polled()
}

/// Reads the cause of the reset from the chip (section 7.3.21), and clears its flags, which
/// otherwise persist.
///
/// Power-up sets the flags of brown-out too. A supply that sags to 2.9 V has ended the program
/// before ([`voltage_detector`](super::voltage_detector)), and its record says
/// so. A supply that falls faster resets at about 1.7 V: brown-out reset is off as the chip
/// comes. That sets the same flags as power-up, and memory that is still in order
/// distinguishes the two.
pub fn reset_cause() -> End {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    if flags.porrstf() {
        End::PowerUp
    } else if flags.borrstf() {
        End::BrownOut
    } else if flags.wdgrstf() {
        End::Watchdog
    } else if flags.sftrstf() {
        End::Software
    } else {
        End::ResetPin
    }
}

/// Feeds the watchdog, for one more period; without effect if it is not running yet.
pub(crate) fn feed_watchdog() {
    watchdog::feed();
}

/// Resets the processor and all peripherals.
pub(crate) fn reset(_cause: End) -> ! {
    SCB::sys_reset()
}
