//! Constants of a board: its crystal, its servo bus, its pins.
//!
//! Addresses are part of the instructions so. The module documentation of a board has its table
//! of pins.

use super::pin::Pin;
use embassy_stm32::interrupt::Interrupt;
use embassy_stm32::pac::dma::{self, Dma};
use embassy_stm32::pac::gpio::vals::Pupdr;
use embassy_stm32::pac::usart::Usart;

/// The source of the chip's high-speed clock.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Crystal {
    /// A crystal at both pins.
    Resonator,
    /// A clock from outside at one of them: the chip's own oscillator is bypassed.
    External,
}

/// A DMA stream and the number of its channel to the USART.
#[derive(Clone, Copy)]
pub struct Stream {
    /// DMA controller.
    pub dma: Dma,
    /// Number of the stream.
    pub number: usize,
    /// Channel, from the table of requests (section 10.3.3).
    pub channel: u8,
}

impl Stream {
    pub(super) fn registers(&self) -> dma::St {
        self.dma.st(self.number)
    }

    /// Stops the stream.
    pub(super) fn stop(&self) {
        self.registers().cr().write(|_| {});
    }

    /// Clears the flags, without which a stream cannot be started (section 10.3.17).
    #[inline]
    pub(super) fn clear(&self) {
        let bit = self.number % 4;
        self.dma.ifcr(self.number / 4).write(|w| {
            w.set_tcif(bit, true);
            w.set_htif(bit, true);
            w.set_teif(bit, true);
            w.set_dmeif(bit, true);
            w.set_feif(bit, true);
        });
    }
}

/// A board.
pub trait Wiring: Send + Sync + 'static {
    /// Its name, that of the image.
    const NAME: &'static str;

    /// Source of the chip's clock.
    const CRYSTAL: Crystal;
    /// Its frequency in MHz; even, as the PLL runs on 2 MHz of it.
    const CRYSTAL_MHZ: u32;

    /// USART of the servo bus.
    const USART: Usart;
    /// Its interrupt, whose handler calls [`bus::on_interrupt`](super::bus::on_interrupt).
    const USART_INTERRUPT: Interrupt;
    /// Its clock in MHz: that of its peripheral bus.
    const USART_MHZ: u32;
    /// Stream of received bytes.
    const RX: Stream;
    /// Stream of bytes to send.
    const TX: Stream;
    /// Pins of the USART: TX and RX.
    const USART_PINS: [Pin; 2];
    /// Alternate function of these pins (data sheet, alternate function mapping).
    const USART_FUNCTION: u8;
    /// Pull at RX: the receive buffer is off while sending, and its output floats. A pin that gets
    /// 5 V bears no pull of the chip (data sheet, five-volt tolerant pins): its resistor is on
    /// the board.
    const RX_PULL: Pupdr;
    /// Direction of the servo bus, high to send.
    const DIRECTION: Pin;

    /// Emergency stop: a closed switch to ground in normal use.
    const STOP: Pin;
    /// Output for a relay or a switch in the servos' supply, high is on.
    const SUPPLY: Pin;
    /// Light that shows the mode.
    const LIGHT: Pin;

    /// Enables the clocks of the USART and of its DMA controller.
    fn enable_clocks();
}
