//! The servo bus on UART1, paced as a line of 1 Mbaud would be.
//!
//! QEMU sends in no time. `flush` therefore reports the end of a transmission
//! when its bytes would have left at 10 µs each, so that the bus master's
//! timing is what it is on a real line. Whoever is at the other end takes the
//! bytes of a burst as sent back to back from the moment the first arrived.

use super::{BUS, time};
use crate::port::{Buffers, Line};
use crate::stop::PolledLine;
use armbridge_shared::servo::BYTE_US;
use core::cell::Cell;
use core::convert::Infallible;
use critical_section::Mutex;
use embedded_hal::digital::{ErrorType, OutputPin};

/// When the last stop bit leaves, in µs.
static SENT_US: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// When the transmission under way ends; `None` if there is none.
pub fn sent_at_us(now_us: u64) -> Option<u64> {
    let sent_us = critical_section::with(|cs| SENT_US.borrow(cs).get());
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
        let now_us = time::now_us();
        critical_section::with(|cs| {
            let sent_us = SENT_US.borrow(cs);
            sent_us.set(sent_us.get().max(now_us) + BYTE_US);
        });
        BUS.send();
    }

    fn is_sent(&self) -> bool {
        !BUS.buffers().is_sending() && sent_at_us(time::now_us()).is_none()
    }
}

/// The direction pin that is not there.
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
pub struct LastLine;

impl PolledLine for LastLine {
    fn drive(&mut self, _on: bool) {}

    fn send(&mut self, byte: u8) {
        BUS.send_polled(byte);
        self.pause_us(BYTE_US as u32);
    }

    fn flush(&mut self) {}

    fn pause_us(&mut self, us: u32) {
        let begun = time::cycles();
        while time::cycles().wrapping_sub(begun) < us * super::CLOCK_MHZ {}
    }
}
