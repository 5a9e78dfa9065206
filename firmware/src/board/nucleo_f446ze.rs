//! Nucleo-F446ZE: STM32F446ZE, 512 kB of flash, with a debug probe on the board.
//!
//! **Built, not run on hardware.** [`stm32`](crate::board::stm32) has all that it shares with
//! other boards: priorities, stop, watchdog. The pins of the servo bus are those of the vendor's
//! DYNAMIXEL Shield, which has the buffers and stands on the board's Arduino headers.
//!
//! | pin  | header | is                | wired to                                |
//! |------|--------|-------------------|-----------------------------------------|
//! | PG14 | D1     | USART6 TX         | the shield                              |
//! | PG9  | D0     | USART6 RX         | the shield                              |
//! | PF15 | D2     | direction, high to send | the shield; 10 kΩ to ground       |
//! | PD15 | D9     | emergency stop, pulled up | normally closed switch to ground |
//! | PA7  | D11    | servos' supply, high is on | driver of a relay, 10 kΩ to ground |
//! | PB7  |        | blue LED, LD2     | on the board                            |
//! | PA11, PA12 | CN13 | USB: link and port | on the board                       |
//!
//! The chip's clock is the 8 MHz that the probe sends while it has power, by its own USB
//! connector, CN1. Without it the board says that it has no crystal, and drives nothing.
//!
//! Pins as in the board's manual, UM1974 (table of the ARDUINO connectors), and the alternate
//! functions as in the chip's data sheet, DS10693, table 11. Of its reference manual, RM0390, the
//! sections that other modules cite have the same registers as in RM0090.

use super::stm32::bus;
use super::stm32::clock_tree::PCLK2_MHZ;
use super::stm32::pin::Pin;
use super::stm32::wiring::{Crystal, Stream, Wiring};
use embassy_stm32::interrupt::{self, Interrupt};
use embassy_stm32::pac::gpio::vals::Pupdr;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::{DMA2, GPIOA, GPIOB, GPIOD, GPIOF, GPIOG, RCC, USART6};

/// The board.
pub struct NucleoF446ze;

impl Wiring for NucleoF446ze {
    const NAME: &str = "nucleo-f446ze";

    const CRYSTAL: Crystal = Crystal::External;
    const CRYSTAL_MHZ: u32 = 8;

    /// Channel 5 of streams 1 and 6 of the second controller is its (RM0390, table 29).
    const USART: Usart = USART6;
    const USART_INTERRUPT: Interrupt = Interrupt::USART6;
    const USART_MHZ: u32 = PCLK2_MHZ;
    const RX: Stream = Stream {
        dma: DMA2,
        number: 1,
        channel: 5,
    };
    const TX: Stream = Stream {
        dma: DMA2,
        number: 6,
        channel: 5,
    };
    const USART_PINS: [Pin; 2] = [Pin::new(GPIOG, 14), Pin::new(GPIOG, 9)];
    const USART_FUNCTION: u8 = 8;
    const RX_PULL: Pupdr = Pupdr::PULL_UP;
    const DIRECTION: Pin = Pin::new(GPIOF, 15);

    const STOP: Pin = Pin::new(GPIOD, 15);
    const SUPPLY: Pin = Pin::new(GPIOA, 7);
    const LIGHT: Pin = Pin::new(GPIOB, 7);

    fn enable_clocks() {
        RCC.ahb1enr().modify(|w| w.set_dma2en(true));
        RCC.apb2enr().modify(|w| w.set_usart6en(true));
        // Reading back makes sure that the clocks are on (RM0390, section 6.2.12).
        let _ = (RCC.ahb1enr().read(), RCC.apb2enr().read());
    }
}

#[embassy_stm32::interrupt]
fn USART6() {
    bus::on_interrupt();
}
