//! The servo bus for the stop sequence: polled, without DMA and interrupts, from any state.
//!
//! The chip runs on its internal oscillator for it, as after a reset ([`fall_back`]): 1 % off
//! at room temperature, which the servos' receivers tolerate.
//!
//! [`fall_back`]: super::oscillator::fall_back

use super::clock_tree::INTERNAL_MHZ;
use super::wiring::Wiring;
use crate::stop::PolledUart;
use armbridge_shared::servo::port::bytes_us;
use core::marker::PhantomData;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::usart::vals::Over8;

/// Sets the divider for this clock (section 30.3.4): clock over baud rate, with 16 samples a
/// bit, or 8 where the clock is too slow for 16, as for 2 Mbaud at 16 MHz. That needs
/// the USART to be off.
pub fn set_divider(usart: Usart, clock_mhz: u32, baud: u32) {
    let baud = baud.max(1);
    let divider = (clock_mhz * 1_000_000 + baud / 2) / baud;
    // The least is one clock a sample, the largest that of the register.
    let value = if divider < 16 {
        let divider = divider.max(8);
        // With 8 samples the fraction has three bits, and the fourth is 0.
        (divider & !7) << 1 | divider & 7
    } else {
        divider.min(0xFFFF)
    };
    let over8 = if divider < 16 {
        Over8::OVERSAMPLING8
    } else {
        Over8::OVERSAMPLING16
    };
    if usart.cr1().read().over8() != over8 {
        usart.cr1().modify(|w| {
            w.set_ue(false);
        });
        usart.cr1().modify(|w| w.set_over8(over8));
        usart.cr1().modify(|w| w.set_ue(true));
    }
    usart.brr().write(|w| w.0 = value);
}

/// The port, polled.
pub struct PolledBus<W> {
    wiring: PhantomData<W>,
    byte_us: u64,
}

/// Cycles of a turn of [`delay`](cortex_m::asm::delay)'s loop, which its count is in: at least
/// three on this core, a subtraction and a branch that is taken (Cortex-M4 technical reference
/// manual, table 3-1).
const TURN_CYCLES: u32 = 3;

/// Waits for at least this time in µs.
fn delay_us(us: u32) {
    cortex_m::asm::delay(us.saturating_mul(INTERNAL_MHZ) / TURN_CYCLES);
}

impl<W: Wiring> PolledBus<W> {
    /// A port that is set up for this speed, with its DMA stopped.
    pub const fn new(baud: u32) -> Self {
        Self {
            wiring: PhantomData,
            byte_us: bytes_us(1, baud),
        }
    }

    /// Waits for a condition, for ten times the duration of a byte at most.
    fn wait(&self, mut done: impl FnMut() -> bool) {
        for _ in 0..10 * self.byte_us {
            if done() {
                return;
            }
            delay_us(1);
        }
    }
}

impl<W: Wiring> PolledUart for PolledBus<W> {
    fn set_baud(&mut self, baud: u32) {
        self.byte_us = bytes_us(1, baud);
        set_divider(W::USART, INTERNAL_MHZ, baud);
    }

    fn drive(&mut self, on: bool) {
        W::DIRECTION.set(on);
    }

    fn send(&mut self, byte: u8) {
        self.wait(|| W::USART.sr().read().txe());
        W::USART.dr().write(|w| w.set_dr(byte.into()));
    }

    fn flush(&mut self) {
        self.wait(|| W::USART.sr().read().tc());
    }

    fn pause_us(&mut self, us: u32) {
        delay_us(us);
    }
}
