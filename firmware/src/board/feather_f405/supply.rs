//! The output for a relay or a switch in the servos' supply: PC3, high is on.
//!
//! PC3 is D11 on the header: free on this board, and D10, which nothing uses, is between it
//! and the stop switch. During a reset and after it the pin is a floating input (section 8.3.1),
//! and a resistor to ground keeps the supply off.

use core::convert::Infallible;
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::pac::{GPIOC, RCC};
use embedded_hal::digital::{ErrorType, OutputPin};

const PIN: usize = 3;

/// The output.
#[derive(Debug)]
pub struct SupplyPin(());

impl SupplyPin {
    /// Takes the pin over from its present owner, from any state, off.
    pub fn take() -> Self {
        RCC.ahb1enr().modify(|w| w.set_gpiocen(true));
        // Reading back makes sure that the clock is on (section 7.2.13).
        let _ = RCC.ahb1enr().read();
        GPIOC.bsrr().write(|w| w.set_br(PIN, true));
        critical_section::with(|_| {
            GPIOC.moder().modify(|w| w.set_moder(PIN, Moder::OUTPUT));
        });
        Self(())
    }
}

impl ErrorType for SupplyPin {
    type Error = Infallible;
}

impl OutputPin for SupplyPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        GPIOC.bsrr().write(|w| w.set_br(PIN, true));
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        GPIOC.bsrr().write(|w| w.set_bs(PIN, true));
        Ok(())
    }
}
