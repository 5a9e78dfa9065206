//! The servo bus on UART1, with the timing of a real line.
//!
//! QEMU sends without delay. A transmission therefore is complete when its bytes would have left
//! at ten bits each, so that the bus master's timing is that of a real line. The other
//! end takes the bytes of a burst as sent back to back from the moment the first
//! arrived. There is no direction pin, and so the line is always released in time.
//!
//! In lockstep the buffers are emptied and filled by [`super::lockstep`]
//! instead of the UART's interrupt handlers.

use super::{BUS, clock};
use crate::crash::memory;
use crate::stop::PolledUart;
use armbridge_servo::bus::{Bus, LineAfter, Received, Transmission};
use armbridge_servo::port::{SERVO_BAUD_MAX, byte_ns, bytes_us};
use embedded_hal_nb::serial::Error;
use heapless::Vec;

/// Bytes passed on at once: more than two replies.
const CHUNK: usize = 32;

/// The servo bus.
#[derive(Debug, Default)]
pub struct BusLine {
    /// Time at which the last stop bit is sent, in ns.
    sent_ns: u64,
    received: Vec<u8, CHUNK>,
}

impl Bus for BusLine {
    const RELEASES_BY_ITSELF: bool = true;
    const BAUD_MAX: u32 = SERVO_BAUD_MAX;

    fn set_baud(&mut self, baud: u32) {
        memory::set_baud(baud);
    }

    fn send(&mut self, bytes: &[u8], _after: LineAfter) {
        let byte_ns = u64::from(byte_ns(memory::baud()));
        self.sent_ns = clock::now_us() * 1_000 + byte_ns * bytes.len() as u64;
        for byte in bytes {
            // The buffer is empty, and longer than any transmission.
            let _ = BUS.buffers().write(*byte);
        }
        if !clock::is_lockstep() {
            BUS.send();
        }
    }

    fn transmission(&mut self) -> Transmission {
        if BUS.buffers().is_sending() || clock::now_us() < self.sent_ns.div_ceil(1_000) {
            Transmission::Sending
        } else {
            Transmission::Complete
        }
    }

    fn release(&mut self) {}

    fn received(&mut self) -> Received<'_> {
        self.received.clear();
        let error = BUS.buffers().take_error().map(|error| error.kind());
        // An error comes before the bytes: its place among them is not known.
        while error.is_none()
            && !self.received.is_full()
            && let Some(byte) = BUS.buffers().read()
        {
            // There is room.
            let _ = self.received.push(byte);
        }
        Received {
            bytes: &self.received,
            error,
        }
    }
}

/// The bus for the stop sequence, timed by the cycle counter alone.
#[derive(Debug)]
pub struct PolledBus {
    byte_us: u32,
}

impl PolledBus {
    /// Takes the port over from its present owner.
    pub fn take() -> Self {
        clock::count();
        BUS.enable();
        Self { byte_us: 0 }
    }
}

impl PolledUart for PolledBus {
    fn set_baud(&mut self, baud: u32) {
        self.byte_us = bytes_us(1, baud) as u32;
    }

    fn drive(&mut self, _on: bool) {}

    fn send(&mut self, byte: u8) {
        BUS.send_polled(byte);
        self.pause_us(self.byte_us);
    }

    fn flush(&mut self) {}

    fn pause_us(&mut self, us: u32) {
        let cycles = us.saturating_mul(clock::cycles_per_us());
        let begun = clock::cycles();
        while clock::cycles().wrapping_sub(begun) < cycles {}
    }
}
