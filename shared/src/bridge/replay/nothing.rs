//! A bus on which nothing happens.

use core::convert::Infallible;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal_nb::serial::{self, Read, Write};

use crate::servo::port::SetBaud;

/// The serial port and its direction pin.
#[derive(Debug)]
pub(super) struct Nothing;

impl serial::ErrorType for Nothing {
    type Error = serial::ErrorKind;
}

impl Read<u8> for Nothing {
    fn read(&mut self) -> nb::Result<u8, Self::Error> {
        Err(nb::Error::WouldBlock)
    }
}

impl Write<u8> for Nothing {
    fn write(&mut self, _byte: u8) -> nb::Result<(), Self::Error> {
        Err(nb::Error::WouldBlock)
    }

    fn flush(&mut self) -> nb::Result<(), Self::Error> {
        Err(nb::Error::WouldBlock)
    }
}

impl SetBaud for Nothing {
    fn set_baud(&mut self, _baud: u32) {}
}

impl digital::ErrorType for Nothing {
    type Error = Infallible;
}

impl OutputPin for Nothing {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
