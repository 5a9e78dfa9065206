//! What the chip adds to how the program ends, and begins again.

use super::bus::PolledBus;
use armbridge_shared::link::message::End;
use cortex_m::peripheral::SCB;
use embassy_stm32::pac::iwdg::vals::Key;
use embassy_stm32::pac::{IWDG, RCC};

/// The servo bus, by polling, whatever state it is in.
pub(crate) fn polled_bus() -> PolledBus {
    PolledBus::take()
}

/// Why there was a reset, as the chip has it (section 7.3.21), and forgets it: its
/// flags stay until they are removed.
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

/// One period more for ending; without effect if it is not running yet.
pub(crate) fn feed_watchdog() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Resets the processor and all else on the chip.
pub(crate) fn reset(_cause: End) -> ! {
    SCB::sys_reset()
}
