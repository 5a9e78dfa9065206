//! The chip's voltage detector: a supply that sags stops the motors while the chip can still
//! send.
//!
//! Below 2.7 V the flash is too slow for the wait states that are set (reference manual, table
//! 10), so that nothing the core reads can be trusted. The detector's highest threshold,
//! nominally 2.9 V (section 5.4.1, PLS), is before that. Its
//! interrupt ends the program: supply of the servos off, stop sequence, reset.
//!
//! The option bytes, which hold the level of brown-out reset, are left as they are: as the
//! chip comes, off.

use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::{EXTI, PWR, RCC};

/// Threshold of nominally 2.9 V.
const THRESHOLD: u8 = 7;
/// Line of the detector at the external interrupt controller (section 12.2.5).
const LINE: usize = 16;

/// Enables it. The handler of PVD must end the program.
pub fn enable() {
    RCC.apb1enr().modify(|w| w.set_pwren(true));
    // Reading back makes sure that the clock is on (section 7.2.13).
    let _ = RCC.apb1enr().read();
    PWR.cr1().modify(|w| {
        w.set_pls(THRESHOLD);
        w.set_pvde(true);
    });
    EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
    EXTI.imr(0).modify(|w| w.set_line(LINE, true));
    interrupt::PVD.set_priority(Priority::P0);
    // SAFETY: its handler is in place; it needs no state.
    unsafe { interrupt::PVD.enable() };
    // A supply that is too low already makes no edge.
    if PWR.csr1().read().pvdo() {
        interrupt::PVD.pend();
    }
}
