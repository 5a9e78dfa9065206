//! Crash handling of the chip: reset cause, watchdog, reset.

use super::bus::{self, Usart3};
use super::supply::SupplyPin;
use crate::board::stm32::polled_bus::PolledBus;
use armbridge_shared::link::message::End;
use cortex_m::peripheral::SCB;
use embassy_stm32::pac::iwdg::vals::Key;
use embassy_stm32::pac::{IWDG, RCC};

/// Switches the servos' supply off, from any state.
pub(crate) fn cut_supply() {
    SupplyPin::take();
}

/// The servo bus for polling, from any state.
pub(crate) fn polled_bus() -> PolledBus<Usart3> {
    bus::polled()
}

/// Reads the cause of the reset from the chip (section 7.3.21), and clears its flags, which
/// otherwise persist.
///
/// Power-up sets the flags of brown-out too. Below which voltage a brown-out
/// resets is in the option bytes, which this program leaves alone: as the chip
/// comes, brown-out reset is off and only its supply supervisor resets, at about
/// 1.7 V. That sets the same flags as power-up, and memory that is still in order
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
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Resets the processor and all peripherals.
pub(crate) fn reset(_cause: End) -> ! {
    SCB::sys_reset()
}
