//! The crystal: whether it oscillates, at boot and afterwards.
//!
//! The chip runs on its internal oscillator after a reset. That one is 1 % off at room
//! temperature and up to 8 % over the range of temperatures (data sheet, internal clock
//! source): enough for the stop sequence, not for USB and the period. A board whose crystal
//! does not start boots on it all the same, says so, and does not drive.
//!
//! A clock from outside is treated as a crystal.
//!
//! Once it has started, the clock security system watches it (reference manual, section
//! 7.2.7). If it stops, the chip is back on its internal oscillator, and a non-maskable
//! interrupt ends the program.

use super::wiring::Crystal;
use embassy_stm32::pac::RCC;
use embassy_stm32::pac::rcc::regs::Cfgr;
use embassy_stm32::pac::rcc::vals::Sw;

/// Polls that a crystal has to start: at 16 MHz and some ten cycles each 60 ms; 2 ms are
/// typical (data sheet, HSE oscillator).
const START_POLLS: u32 = 100_000;
/// Polls that a switch of the clock may take; a few cycles do.
const SWITCH_POLLS: u32 = 1_000;

/// Runs core and buses on the internal oscillator, undivided, as after a reset: for the stop
/// sequence, which then depends on no clock that may have failed. Prescalers survive the
/// failure of a crystal, so that they are cleared too.
pub fn fall_back() {
    RCC.cr().modify(|w| w.set_hsion(true));
    let _ = (0..SWITCH_POLLS).any(|_| RCC.cr().read().hsirdy());
    RCC.cfgr().write_value(Cfgr(0));
    let _ = (0..SWITCH_POLLS).any(|_| RCC.cfgr().read().sws() == Sw::HSI);
}

/// Starts the crystal; false if it does not start.
pub fn start(crystal: Crystal) -> bool {
    RCC.cr()
        .modify(|w| w.set_hsebyp(crystal == Crystal::External));
    RCC.cr().modify(|w| w.set_hseon(true));
    let has_started = (0..START_POLLS).any(|_| RCC.cr().read().hserdy());
    if !has_started {
        RCC.cr().modify(|w| w.set_hseon(false));
    }
    has_started
}

/// Has the chip watch the crystal from now on.
pub fn watch() {
    RCC.cr().modify(|w| w.set_csson(true));
}
