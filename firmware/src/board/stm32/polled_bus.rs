//! The servo bus for the stop sequence: polled, without DMA and interrupts, from any state.
//!
//! The chip runs on its internal oscillator for it, as after a reset ([`fall_back`]): 1 % off
//! at room temperature, which the servos' receivers tolerate.
//!
//! [`fall_back`]: super::oscillator::fall_back

use super::baud::set_divider;
use super::clock_tree::INTERNAL_MHZ;
use super::wiring::Wiring;
use crate::stop::PolledUart;
use armbridge_servo::port::bytes_us;
use core::marker::PhantomData;

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
