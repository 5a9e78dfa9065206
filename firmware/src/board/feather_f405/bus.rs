//! The servo bus on USART3, on its registers.
//!
//! Interrupt driven both ways. The end of a transmission is TC, not TXE: the
//! last stop bit has left (section 30.3.2). That interrupt wakes the tick,
//! which lowers the direction pin; a servo may speak 45 µs later. Received bytes
//! wake it when their expected number is reached (see [`crate::port`]).

use super::{CORE_MHZ, PCLK1_MHZ, time};
use crate::crash::memory;
use crate::port::{Buffers, Line, LineError};
use crate::stop::PolledUart;
use armbridge_shared::servo::port::bytes_us;
use core::convert::Infallible;
use embassy_stm32::interrupt;
use embassy_stm32::pac::gpio::vals::{Moder, Ospeedr, Pupdr};
use embassy_stm32::pac::rcc::vals::Sw;
use embassy_stm32::pac::{GPIOB, GPIOC, RCC, USART3};
use embedded_hal::digital::{ErrorType, OutputPin};

/// PB10 and PB11 are USART3 as alternate function 7 (data sheet, table 9).
const TX_PIN: usize = 10;
const RX_PIN: usize = 11;
const USART3_FUNCTION: u8 = 7;
/// Direction pin: PC6.
const DIRECTION_PIN: usize = 6;

/// Core, APB1 and all else after a reset run at the internal oscillator's
/// 16 MHz (section 7.2.2).
const RESET_MHZ: u32 = 16;

static BUFFERS: Buffers = Buffers::new();

/// Enables port and pins, at the clocks in force.
pub fn enable() {
    set_up();
    USART3.cr1().modify(|w| w.set_rxneie(true));
}

/// Signal that ends the wait of the tick; see [`Buffers::expect`].
pub fn expect(bytes: Option<usize>) -> bool {
    BUFFERS.expect(bytes)
}

/// Whether there are bits to be sent; their end is an interrupt.
pub fn is_sending() -> bool {
    !BusLine.is_sent()
}

/// Sets up port and pins without interrupts, the line released.
fn set_up() {
    RCC.ahb1enr().modify(|w| {
        w.set_gpioben(true);
        w.set_gpiocen(true);
    });
    RCC.apb1enr().modify(|w| w.set_usart3en(true));
    // Reading back makes sure that the clocks are on (section 7.2.13).
    let _ = (RCC.ahb1enr().read(), RCC.apb1enr().read());

    GPIOC.bsrr().write(|w| w.set_br(DIRECTION_PIN, true));
    GPIOC
        .moder()
        .modify(|w| w.set_moder(DIRECTION_PIN, Moder::OUTPUT));

    USART3.cr1().write(|w| w.set_ue(false));
    set_divider(memory::baud());
    // Zero in CR1 and CR2 is 8N1. TE sends an idle frame first.
    USART3.cr1().write(|w| {
        w.set_ue(true);
        w.set_te(true);
        w.set_re(true);
    });

    for pin in [TX_PIN, RX_PIN] {
        GPIOB
            .afr(pin / 8)
            .modify(|w| w.set_afr(pin % 8, USART3_FUNCTION));
        // A bit is 1 µs: edges of the second speed, 10 ns, suffice.
        GPIOB
            .ospeedr()
            .modify(|w| w.set_ospeedr(pin, Ospeedr::MEDIUM_SPEED));
        // The receive buffer is off while sending: its output floats, so the pin has a pull-up.
        GPIOB.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::PULL_UP));
        GPIOB.moder().modify(|w| w.set_moder(pin, Moder::ALTERNATE));
    }
}

/// Sets the divider (section 30.3.4, 16 samples a bit): clock over baud rate. At
/// 42 and at 16 MHz that is exact for 1 Mbaud.
fn set_divider(baud: u32) {
    let clock_mhz = if runs_at_full_speed() {
        PCLK1_MHZ
    } else {
        RESET_MHZ
    };
    let baud = baud.max(1);
    let divider = (clock_mhz * 1_000_000 + baud / 2) / baud;
    // From 16, one sample each, to the largest value of the register.
    USART3.brr().write(|w| w.0 = divider.clamp(16, 0xFFFF));
}

/// Whether the core runs at [`CORE_MHZ`].
fn runs_at_full_speed() -> bool {
    RCC.cfgr().read().sws() == Sw::PLL1_P
}

/// One handler for all of the port's interrupts.
#[interrupt]
fn USART3() {
    let status = USART3.sr().read();
    if status.rxne() || status.ore() || status.fe() || status.ne() {
        // Reading SR, then DR clears all four (section 30.6.1).
        let byte = USART3.dr().read().dr() as u8;
        if status.fe() {
            BUFFERS.report_error(LineError::Framing);
        } else if status.ne() {
            BUFFERS.report_error(LineError::Noise);
        } else {
            // After an overrun this byte is good, the one after it is lost.
            BUFFERS.received(byte);
        }
        if status.ore() {
            BUFFERS.report_error(LineError::Overrun);
        }
        if BUFFERS.is_due() {
            time::wake();
        }
    }
    let enabled = USART3.cr1().read();
    if enabled.txeie() && status.txe() {
        if let Some(byte) = BUFFERS.next_to_send() {
            // SR was read above: writing DR now clears TC too.
            USART3.dr().write(|w| w.set_dr(byte.into()));
        } else {
            USART3.cr1().modify(|w| {
                w.set_txeie(false);
                w.set_tcie(true);
            });
        }
    } else if enabled.tcie() && status.tc() {
        USART3.cr1().modify(|w| w.set_tcie(false));
        time::wake();
    }
}

/// The servo bus, for [`crate::port::Port`].
#[derive(Debug)]
pub struct BusLine;

impl Line for BusLine {
    fn buffers(&self) -> &Buffers {
        &BUFFERS
    }

    fn start_sending(&self) {
        // The interrupt handler changes the same register.
        critical_section::with(|_| USART3.cr1().modify(|w| w.set_txeie(true)));
    }

    fn is_sent(&self) -> bool {
        // TXEIE stays on until the last byte is in the shift register, and
        // from then on TC marks the end.
        !BUFFERS.is_sending() && !USART3.cr1().read().txeie() && USART3.sr().read().tc()
    }

    fn set_baud(&self, baud: u32) {
        memory::set_baud(baud);
        set_divider(baud);
    }
}

/// The direction pin: high to send.
#[derive(Debug)]
pub struct Direction;

impl ErrorType for Direction {
    type Error = Infallible;
}

impl OutputPin for Direction {
    fn set_low(&mut self) -> Result<(), Infallible> {
        GPIOC.bsrr().write(|w| w.set_br(DIRECTION_PIN, true));
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        GPIOC.bsrr().write(|w| w.set_bs(DIRECTION_PIN, true));
        Ok(())
    }
}

/// The bus for the stop sequence. After a reset its clock is the internal
/// oscillator, 1 % off at room temperature, which the servos' receivers tolerate.
#[derive(Debug)]
pub struct PolledBus {
    core_mhz: u32,
    byte_us: u64,
}

impl PolledBus {
    /// Takes the port over from its present owner.
    pub fn take() -> Self {
        set_up();
        let core_mhz = if runs_at_full_speed() {
            CORE_MHZ
        } else {
            RESET_MHZ
        };
        Self {
            core_mhz,
            byte_us: bytes_us(1, memory::baud()),
        }
    }

    /// Waits for a condition, for ten times the duration of a byte at most.
    fn wait(&self, mut done: impl FnMut() -> bool) {
        for _ in 0..10 * self.byte_us {
            if done() {
                return;
            }
            cortex_m::asm::delay(self.core_mhz);
        }
    }
}

impl PolledUart for PolledBus {
    fn set_baud(&mut self, baud: u32) {
        self.byte_us = bytes_us(1, baud);
        set_divider(baud);
    }

    fn drive(&mut self, on: bool) {
        // It cannot fail.
        let _ = Direction.set_state(on.into());
    }

    fn send(&mut self, byte: u8) {
        self.wait(|| USART3.sr().read().txe());
        USART3.dr().write(|w| w.set_dr(byte.into()));
    }

    fn flush(&mut self) {
        self.wait(|| USART3.sr().read().tc());
    }

    fn pause_us(&mut self, us: u32) {
        cortex_m::asm::delay(us.saturating_mul(self.core_mhz));
    }
}
