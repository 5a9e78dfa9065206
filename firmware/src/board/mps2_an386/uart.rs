//! CMSDK APB UART, interrupt driven both ways.
//!
//! The receiver holds one byte and QEMU hands over the next only when it was
//! fetched, so an overrun is impossible here. QEMU sends a byte the moment it is
//! written; only a full socket keeps the transmitter busy, and then the TX
//! interrupt continues.

use crate::port::Buffers;
use core::future::poll_fn;
use core::ptr;
use core::task::Poll;
use embassy_sync::waitqueue::AtomicWaker;

/// Offsets of the registers, from the CMSDK technical reference manual.
mod register {
    pub(super) const DATA: usize = 0x00;
    pub(super) const STATE: usize = 0x04;
    pub(super) const CTRL: usize = 0x08;
    /// Reads pending interrupts, clears those written.
    pub(super) const INT: usize = 0x0C;
    pub(super) const BAUDDIV: usize = 0x10;
}

const STATE_TX_FULL: u32 = 1 << 0;
const STATE_RX_FULL: u32 = 1 << 1;

/// Transmitter, receiver, and the receiver's interrupt.
const CTRL_ON: u32 = 1 << 0 | 1 << 1 | 1 << 3;
const CTRL_TX_INT: u32 = 1 << 2;

const INT_TX: u32 = 1 << 0;
const INT_RX: u32 = 1 << 1;

/// 25 MHz / 25 = 1 Mbaud. QEMU ignores the rate, but takes the UART for
/// switched off below 16.
const DIVIDER: u32 = super::CLOCK_MHZ;

/// One UART with its buffers.
pub struct Uart {
    base: usize,
    buffers: Buffers,
    /// The one task that waits for this UART.
    waiting: AtomicWaker,
}

impl Uart {
    /// The UART with its registers at `base`; one of this machine's, and each
    /// only once.
    pub(super) const fn new(base: usize) -> Self {
        Self {
            base,
            buffers: Buffers::new(),
            waiting: AtomicWaker::new(),
        }
    }

    /// Enables the UART.
    pub fn enable(&self) {
        self.write_register(register::BAUDDIV, DIVIDER);
        self.write_register(register::CTRL, CTRL_ON);
    }

    /// Buffers of received bytes and of bytes to send.
    pub fn buffers(&self) -> &Buffers {
        &self.buffers
    }

    /// The RX interrupt's handler.
    pub fn on_receive(&self) {
        // Before reading: a later byte triggers the interrupt again.
        self.write_register(register::INT, INT_RX);
        while self.read_register(register::STATE) & STATE_RX_FULL != 0 {
            self.buffers
                .received(self.read_register(register::DATA) as u8);
        }
        self.waiting.wake();
    }

    /// The TX interrupt's handler.
    pub fn on_transmit(&self) {
        self.write_register(register::INT, INT_TX);
        self.send();
        self.waiting.wake();
    }

    /// Sends as much as the line takes now; the TX interrupt does the rest, and
    /// is on only while the line is busy.
    pub fn send(&self) {
        // One at a time: a task and the interrupt handler both come here.
        critical_section::with(|_| {
            // Before reading: a line that becomes free later triggers the interrupt.
            self.write_register(register::CTRL, CTRL_ON | CTRL_TX_INT);
            while self.read_register(register::STATE) & STATE_TX_FULL == 0 {
                let Some(byte) = self.buffers.next_to_send() else {
                    self.write_register(register::CTRL, CTRL_ON);
                    self.write_register(register::INT, INT_TX);
                    return;
                };
                self.write_register(register::DATA, u32::from(byte));
            }
        });
    }

    /// Sends a byte by polling, past the buffers; gives up when no reader takes
    /// it for some milliseconds.
    pub fn send_polled(&self, byte: u8) {
        for _ in 0..20_000 {
            if self.read_register(register::STATE) & STATE_TX_FULL == 0 {
                self.write_register(register::DATA, u32::from(byte));
                return;
            }
        }
    }

    /// Waits until `done` holds; it is evaluated after each interrupt. Only
    /// one task may wait for a UART.
    pub async fn until(&self, mut done: impl FnMut(&Buffers) -> bool) {
        poll_fn(|context| {
            self.waiting.register(context.waker());
            if done(&self.buffers) {
                Poll::Ready(())
            } else {
                Poll::Pending
            }
        })
        .await;
    }

    fn read_register(&self, offset: usize) -> u32 {
        // SAFETY: `base` is that of a UART of this machine and `offset` that of
        // one of its registers, which are 32 bits wide and always there.
        // Reading has no effect on memory.
        unsafe { ptr::read_volatile((self.base + offset) as *const u32) }
    }

    fn write_register(&self, offset: usize, value: u32) {
        // SAFETY: as for reading; none of these registers starts a transfer
        // to or from memory.
        unsafe { ptr::write_volatile((self.base + offset) as *mut u32, value) }
    }
}
