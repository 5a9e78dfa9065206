//! A pin, by the registers of its port (reference manual, section 8).
//!
//! After a reset all pins but those of the debugger are floating inputs.

use core::convert::Infallible;
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Moder, Ospeedr, Pupdr};
use embassy_stm32::pac::{GPIOA, RCC};
use embedded_hal::digital::{ErrorType, OutputPin};

/// Distance of the registers of two ports in bytes (section 2.3).
const PORT_LEN: usize = 0x400;

/// A pin: a port and a number. Its modes can be set from any state.
#[derive(Clone, Copy)]
pub struct Pin {
    port: Gpio,
    number: usize,
}

impl Pin {
    /// Pin `number` of `port`, from 0 to 15.
    ///
    /// # Panics
    /// On a greater number. Boards have their pins as constants: the compiler says so.
    pub const fn new(port: Gpio, number: usize) -> Self {
        assert!(number < 16);
        Self { port, number }
    }

    /// Sets the level of the output.
    #[inline]
    pub fn set(self, is_high: bool) {
        self.port.bsrr().write(|w| {
            if is_high {
                w.set_bs(self.number, true);
            } else {
                w.set_br(self.number, true);
            }
        });
    }

    /// The level at the pin.
    pub fn is_high(self) -> bool {
        self.port.idr().read().idr(self.number).to_bits() != 0
    }

    /// Makes it an output of this level.
    pub fn make_output(self, is_high: bool) {
        self.enable_port();
        self.set(is_high);
        self.set_mode(Moder::OUTPUT);
    }

    /// Makes it an input with the chip's pull-up, of 30 to 50 kΩ (data sheet, I/O static
    /// characteristics).
    pub fn make_pulled_up(self) {
        self.enable_port();
        self.pull(Pupdr::PULL_UP);
        self.set_mode(Moder::INPUT);
    }

    /// Connects it to a peripheral by this alternate function. Edges are of the second
    /// speed, 10 ns: a bit is 0.5 µs at least.
    pub fn connect(self, function: u8, pull: Pupdr) {
        self.enable_port();
        let number = self.number;
        critical_section::with(|_| {
            let afr = self.port.afr(number / 8);
            afr.modify(|w| w.set_afr(number % 8, function));
            let speed = self.port.ospeedr();
            speed.modify(|w| w.set_ospeedr(number, Ospeedr::MEDIUM_SPEED));
        });
        self.pull(pull);
        self.set_mode(Moder::ALTERNATE);
    }

    /// Sets its mode alone; the clock of its port is on.
    pub fn set_mode(self, mode: Moder) {
        critical_section::with(|_| self.port.moder().modify(|w| w.set_moder(self.number, mode)));
    }

    fn pull(self, pull: Pupdr) {
        let pulls = self.port.pupdr();
        critical_section::with(|_| pulls.modify(|w| w.set_pupdr(self.number, pull)));
    }

    /// Enables the clock of its port: the bits are in the order of the ports (section 7.3.10).
    fn enable_port(self) {
        let index = (self.port.as_ptr() as usize - GPIOA.as_ptr() as usize) / PORT_LEN;
        RCC.ahb1enr().modify(|w| w.0 |= 1 << index);
        // Reading back makes sure that the clock is on (section 7.2.13).
        let _ = RCC.ahb1enr().read();
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}
