//! The servo bus on UART1, with the timing of a real line.
//!
//! QEMU sends without delay. `flush` therefore reports the end of a transmission
//! when its bytes would have left at ten bits each, so that the bus master's
//! timing is that of a real line. The other end takes the
//! bytes of a burst as sent back to back from the moment the first arrived.
//!
//! In lockstep the port's buffers are emptied and filled by [`super::lockstep`]
//! instead of the UART's interrupt handlers.

use super::{BUS, clock};
use crate::crash::memory;
use crate::port::{Buffers, Line};
use crate::stop::PolledUart;
use armbridge_shared::servo::port::{byte_ns, bytes_us};
use core::cell::Cell;
use core::convert::Infallible;
use critical_section::Mutex;
use embedded_hal::digital::{ErrorType, OutputPin};

/// Time at which the last stop bit is sent, in ns.
static SENT_NS: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));
/// End of the transmission under way; `None` if there is none.
pub fn sent_at_us(now_us: u64) -> Option<u64> {
    let sent_us = critical_section::with(|cs| SENT_NS.borrow(cs).get()).div_ceil(1_000);
    (sent_us > now_us).then_some(sent_us)
}

/// The servo bus, for [`crate::port::Port`].
#[derive(Debug)]
pub struct BusLine;

impl Line for BusLine {
    fn buffers(&self) -> &Buffers {
        BUS.buffers()
    }

    /// Called for every byte written.
    fn start_sending(&self) {
        let now_ns = clock::now_us() * 1_000;
        let byte_ns = u64::from(byte_ns(memory::baud()));
        critical_section::with(|cs| {
            let sent_ns = SENT_NS.borrow(cs);
            sent_ns.set(sent_ns.get().max(now_ns) + byte_ns);
        });
        if !clock::is_lockstep() {
            BUS.send();
        }
    }

    fn is_sent(&self) -> bool {
        !BUS.buffers().is_sending() && sent_at_us(clock::now_us()).is_none()
    }

    fn set_baud(&self, baud: u32) {
        memory::set_baud(baud);
    }
}

/// Placeholder of the direction pin, which the machine lacks.
#[derive(Debug)]
pub struct NoPin;

impl ErrorType for NoPin {
    type Error = Infallible;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
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
