//! Adafruit Feather STM32F405 Express: STM32F405RG, 1 MB of flash.
//!
//! **Built, not run on hardware.** [`stm32`](crate::board::stm32) has all that it shares with
//! other boards: priorities, stop, watchdog.
//!
//! | pin  | Feather | is                | wired to                               |
//! |------|---------|-------------------|----------------------------------------|
//! | PB10 | TX      | USART3 TX         | input of the buffer that drives DATA   |
//! | PB11 | RX      | USART3 RX         | output of the buffer that listens to DATA, 10 kΩ to 3.3 V |
//! | PC2  | D12     | direction, high to send | enables of both buffers, 10 kΩ to ground |
//! | PB8  | D9      | emergency stop, pulled up | normally closed switch to ground |
//! | PC3  | D11     | servos' supply, high is on | driver of a relay, 10 kΩ to ground |
//! | PC1  | D13     | red LED           | on the board                           |
//! | PA11, PA12 | USB | link and port    | on the board                           |
//!
//! The buffer is a 74HCT126 with an inverter or a 74HCT241 at 5 V: HC, as in the servo's manual,
//! asks for a higher level than a pin of 3.3 V gives. While the processor is in reset all its
//! pins float: the resistor at PC2 then keeps the line free. D10, which nothing uses, is between
//! D11 and the stop switch. TX, RX and D12 are the pins of the `DynaFeather` wing as it is sold.

use super::stm32::bus;
use super::stm32::clock_tree::PCLK1_MHZ;
use super::stm32::pin::Pin;
use super::stm32::wiring::{Crystal, Stream, Wiring};
use embassy_stm32::interrupt::{self, Interrupt};
use embassy_stm32::pac::gpio::vals::Pupdr;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::{DMA1, GPIOB, GPIOC, RCC, USART3};

/// The board.
pub struct FeatherF405;

impl Wiring for FeatherF405 {
    const NAME: &str = "feather-f405";

    const CRYSTAL: Crystal = Crystal::Resonator;
    const CRYSTAL_MHZ: u32 = 12;

    /// Channel 4 of streams 1 and 3 is its (table 42).
    const USART: Usart = USART3;
    const USART_INTERRUPT: Interrupt = Interrupt::USART3;
    const USART_MHZ: u32 = PCLK1_MHZ;
    const RX: Stream = Stream {
        dma: DMA1,
        number: 1,
        channel: 4,
    };
    const TX: Stream = Stream {
        dma: DMA1,
        number: 3,
        channel: 4,
    };
    const USART_PINS: [Pin; 2] = [Pin::new(GPIOB, 10), Pin::new(GPIOB, 11)];
    const USART_FUNCTION: u8 = 7;
    const RX_PULL: Pupdr = Pupdr::FLOATING;
    const DIRECTION: Pin = Pin::new(GPIOC, 2);

    const STOP: Pin = Pin::new(GPIOB, 8);
    const SUPPLY: Pin = Pin::new(GPIOC, 3);
    const LIGHT: Pin = Pin::new(GPIOC, 1);

    fn enable_clocks() {
        RCC.ahb1enr().modify(|w| w.set_dma1en(true));
        RCC.apb1enr().modify(|w| w.set_usart3en(true));
        // Reading back makes sure that the clocks are on (section 7.2.13).
        let _ = (RCC.ahb1enr().read(), RCC.apb1enr().read());
    }
}

#[embassy_stm32::interrupt]
fn USART3() {
    bus::on_interrupt();
}
