//! The output for the servos' supply, which the machine lacks: each change is a line of the log.
//!
//! The lines have the board's time, and tests read them. The virtual servos keep their power.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, Ordering};
use embedded_hal::digital::{ErrorType, OutputPin};

static IS_ON: AtomicBool = AtomicBool::new(false);

/// Placeholder of the output.
#[derive(Debug)]
pub struct SupplyPin(());

impl SupplyPin {
    /// Takes it over from its present owner, from any state, off.
    pub fn take() -> Self {
        let mut pin = Self(());
        // It cannot fail.
        let _ = pin.set_low();
        pin
    }
}

impl ErrorType for SupplyPin {
    type Error = Infallible;
}

impl OutputPin for SupplyPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        if IS_ON.swap(false, Ordering::Relaxed) {
            defmt::info!("supply off");
        }
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        if !IS_ON.swap(true, Ordering::Relaxed) {
            defmt::info!("supply on");
        }
        Ok(())
    }
}
