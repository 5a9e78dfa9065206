//! The line as the master knows it: firmware and speed of the servos, and how far they are
//! set up.

use super::{Busy, Master};
use crate::servo::Firmware;
use crate::servo::exchange::Readiness;
use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

impl<S, D> Master<S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// What runs on the servos, and the speed of the line.
    ///
    /// # Errors
    /// [`Busy`] while a transaction is under way.
    pub fn set_line(&mut self, firmware: Firmware, baud: u32) -> Result<(), Busy> {
        if !self.is_idle() {
            return Err(Busy);
        }
        self.line.firmware = firmware;
        if self.line.baud != baud {
            self.line.baud = baud;
            self.serial.set_baud(baud);
        }
        Ok(())
    }

    /// Time in µs that a tick's exchange may take: decides how much of it may be
    /// margin.
    pub fn set_available(&mut self, us: u32) {
        self.line.available_us = us;
    }

    /// Stock servos have been prepared, or nothing is known of their settings. Until
    /// they are prepared a tick only asks where they are.
    pub fn set_prepared(&mut self, is_prepared: bool) {
        self.line.readiness = if is_prepared {
            Readiness::Prepared
        } else {
            Readiness::Unknown
        };
    }

    /// Stock servos let go of their shafts: they are prepared no longer, but answer as
    /// soon as before.
    pub fn note_released(&mut self) {
        if self.line.readiness == Readiness::Prepared {
            self.line.readiness = Readiness::Released;
        }
    }

    /// Whether torque can be given to the servos.
    pub fn is_prepared(&self) -> bool {
        self.line.readiness == Readiness::Prepared || self.line.firmware == Firmware::Morpheus
    }

    /// Whether the servos answer without the return delay of the factory.
    pub fn answers_soon(&self) -> bool {
        self.line.readiness.answers_soon() || self.line.firmware == Firmware::Morpheus
    }

    /// How far stock servos are set up.
    pub fn readiness(&self) -> Readiness {
        self.line.readiness
    }

    /// What runs on the servos.
    pub fn firmware(&self) -> Firmware {
        self.line.firmware
    }

    /// Bits per second.
    pub fn baud(&self) -> u32 {
        self.line.baud
    }
}
