//! Serial port of the virtual board on the servo bus.
//!
//! Two handles on the same state: the board's, with `embedded-hal-nb`'s traits
//! as a hardware port has them, of which
//! [`SerialBus`](armbridge_servo::serial_bus::SerialBus) makes a bus, and the bench's, which puts bytes in and takes
//! bytes out. A byte takes ten bits to send; `flush` is done after the last stop
//! bit. Writes never block: the buffer is unbounded.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use armbridge_servo::port::{BAUD_RATES, SetBaud, byte_ns};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal_nb::serial;

#[derive(Debug)]
struct State {
    now_us: u64,
    baud: u32,
    received: VecDeque<u8>,
    sent: Vec<u8>,
    sent_until_ns: u64,
}

impl Default for State {
    fn default() -> Self {
        Self {
            now_us: 0,
            baud: BAUD_RATES[0],
            received: VecDeque::new(),
            sent: Vec::new(),
            sent_until_ns: 0,
        }
    }
}

impl State {
    fn sent_until_us(&self) -> u64 {
        self.sent_until_ns.div_ceil(1_000)
    }
}

/// A handle on the port.
#[derive(Clone, Debug, Default)]
pub(crate) struct Uart(Arc<Mutex<State>>);

impl Uart {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the time, and adds received bytes.
    pub(crate) fn deliver(&self, now_us: u64, bytes: &[u8]) {
        let mut state = self.state();
        state.now_us = now_us;
        state.received.extend(bytes);
    }

    /// Takes the bytes written since the last call.
    pub(crate) fn take_sent(&self, into: &mut Vec<u8>) {
        into.append(&mut self.state().sent);
    }

    /// End of the present transmission, if there is one.
    pub(crate) fn transmit_complete_us(&self) -> Option<u64> {
        let state = self.state();
        (state.sent_until_us() > state.now_us).then_some(state.sent_until_us())
    }

    /// Bits per second at which it sends and receives.
    pub(crate) fn baud(&self) -> u32 {
        self.state().baud
    }
}

impl SetBaud for Uart {
    fn set_baud(&mut self, baud: u32) {
        self.state().baud = baud.max(1);
    }
}

impl serial::ErrorType for Uart {
    type Error = Infallible;
}

impl serial::Read<u8> for Uart {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        self.state()
            .received
            .pop_front()
            .ok_or(nb::Error::WouldBlock)
    }
}

impl serial::Write<u8> for Uart {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        let mut state = self.state();
        state.sent.push(byte);
        let byte_ns = u64::from(byte_ns(state.baud));
        state.sent_until_ns = state.sent_until_ns.max(state.now_us * 1_000) + byte_ns;
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        match self.transmit_complete_us() {
            Some(_) => Err(nb::Error::WouldBlock),
            None => Ok(()),
        }
    }
}

/// The direction pin of a bus whose wire is modelled elsewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Direction;

impl digital::ErrorType for Direction {
    type Error = Infallible;
}

impl OutputPin for Direction {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
