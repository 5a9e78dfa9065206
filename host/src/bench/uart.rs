//! The virtual board's serial port on the servo bus.
//!
//! Two handles on the same state: the board's, with `embedded-hal-nb`'s traits
//! as a hardware port has them, and the bench's, which puts bytes in and takes
//! bytes out. A byte takes 10 µs to send; `flush` is done when the last stop
//! bit has left. Writes never block: the buffer is as long as need be.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use armbridge_shared::servo::BYTE_US;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal_nb::serial;

#[derive(Debug, Default)]
struct State {
    now_us: u64,
    received: VecDeque<u8>,
    sent: Vec<u8>,
    sent_until_us: u64,
}

/// A handle on the port.
#[derive(Clone, Debug, Default)]
pub struct Uart(Rc<RefCell<State>>);

impl Uart {
    /// Sets the time and hands over bytes that have arrived.
    pub fn deliver(&self, now_us: u64, bytes: &[u8]) {
        let mut state = self.0.borrow_mut();
        state.now_us = now_us;
        state.received.extend(bytes);
    }

    /// Takes the bytes written since the last call.
    pub fn take_sent(&self, into: &mut Vec<u8>) {
        into.append(&mut self.0.borrow_mut().sent);
    }

    /// When the transmission under way will be complete, if there is one.
    pub fn transmit_complete_us(&self) -> Option<u64> {
        let state = self.0.borrow();
        (state.sent_until_us > state.now_us).then_some(state.sent_until_us)
    }
}

impl serial::ErrorType for Uart {
    type Error = Infallible;
}

impl serial::Read<u8> for Uart {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        self.0
            .borrow_mut()
            .received
            .pop_front()
            .ok_or(nb::Error::WouldBlock)
    }
}

impl serial::Write<u8> for Uart {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        let mut state = self.0.borrow_mut();
        state.sent.push(byte);
        state.sent_until_us = state.sent_until_us.max(state.now_us) + BYTE_US;
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
pub struct Direction;

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
