//! A buffered serial port for the bus master.
//!
//! [`Buffers`] sit between a UART's interrupt handler and the code that uses
//! the port. [`Port`] puts `embedded-hal-nb` serial traits on top: `write`
//! never blocks while the buffer has room, `flush` blocks until the last stop
//! bit has left, a receiver's error comes out of `read`, once.
//!
//! # Waking
//!
//! A reply of the servos is 14 bytes, 10 µs apart, and the master can do nothing
//! before the last of them. It announces how many it waits for ([`Buffers::expect`]), and
//! the interrupt handler wakes it at this count, or when the receiver reports an
//! error ([`Buffers::is_due`]): once a reply, not once a byte, which costs a poll each,
//! some 700 instructions. Bytes that it does not expect, echo or noise on
//! an idle line, stay in the buffer until its next poll.

use crate::ring::ByteRing;
use armbridge_shared::servo::port::SetBaud;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering, compiler_fence};
use embedded_hal_nb::serial::{ErrorKind, ErrorType, Read, Write};

/// Bytes in either direction. The longest transmission, the stop sequence's
/// flush, is 210 bytes.
pub const BUFFER_LEN: usize = 512;

/// Buffers shared by an interrupt handler and a port.
#[derive(Debug, Default)]
pub struct Buffers {
    /// Received, not yet read.
    rx: ByteRing<BUFFER_LEN>,
    /// Written, not yet sent.
    tx: ByteRing<BUFFER_LEN>,
    /// The last error of the receiver, as a [`LineError`] code; 0 if none.
    error: AtomicU8,
    /// Number of received bytes that ends a wait; see [`NOTHING_EXPECTED`].
    expected: AtomicU32,
}

/// No number of bytes ends a wait.
const NOTHING_EXPECTED: u32 = 0;

/// Errors that a receiver reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum LineError {
    /// A byte was received before the previous one was read.
    Overrun = 1,
    /// No stop bit.
    Framing = 2,
    /// Samples of one bit disagreed.
    Noise = 3,
}

impl embedded_hal_nb::serial::Error for LineError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Overrun => ErrorKind::Overrun,
            Self::Framing => ErrorKind::FrameFormat,
            Self::Noise => ErrorKind::Noise,
        }
    }
}

impl Buffers {
    /// Empty buffers.
    pub const fn new() -> Self {
        Self {
            rx: ByteRing::new(),
            tx: ByteRing::new(),
            error: AtomicU8::new(0),
            expected: AtomicU32::new(NOTHING_EXPECTED),
        }
    }

    /// Sets the number of bytes that ends the reader's wait, as an error always does; `None`
    /// for no number. True if that many have been received already.
    pub fn expect(&self, bytes: Option<usize>) -> bool {
        // At most the capacity: a full buffer is due.
        let expected = bytes.map_or(NOTHING_EXPECTED, |bytes| bytes.clamp(1, BUFFER_LEN) as u32);
        self.expected.store(expected, Ordering::Relaxed);
        // A byte received before this is counted here, a later one by its interrupt
        // handler.
        compiler_fence(Ordering::SeqCst);
        expected != NOTHING_EXPECTED && self.rx.len() >= expected as usize
    }

    /// Whether the last byte or error ends the reader's wait. The interrupt handler
    /// calls it after each.
    pub fn is_due(&self) -> bool {
        let expected = self.expected.load(Ordering::Relaxed);
        expected != NOTHING_EXPECTED
            && (self.rx.len() >= expected as usize || self.error.load(Ordering::Relaxed) != 0)
    }

    /// Takes a received byte, from the interrupt handler.
    pub fn received(&self, byte: u8) {
        if !self.rx.push(byte) {
            self.report_error(LineError::Overrun);
        }
    }

    /// Records an error of the receiver, from the interrupt handler.
    pub fn report_error(&self, error: LineError) {
        self.error.store(error as u8, Ordering::Release);
    }

    /// Takes the next byte to send, from the interrupt handler.
    pub fn next_to_send(&self) -> Option<u8> {
        self.tx.pop()
    }

    /// Takes the oldest received byte.
    pub fn read(&self) -> Option<u8> {
        self.rx.pop()
    }

    /// Buffers a byte to be sent; `false` if there is no room.
    pub fn write(&self, byte: u8) -> bool {
        self.tx.push(byte)
    }

    /// Whether there are bytes to read.
    pub fn has_received(&self) -> bool {
        !self.rx.is_empty()
    }

    /// Whether there is room for a byte to be sent.
    pub fn has_room(&self) -> bool {
        !self.tx.is_full()
    }

    /// Whether there are bytes to be sent.
    pub fn is_sending(&self) -> bool {
        !self.tx.is_empty()
    }

    fn take_error(&self) -> Option<LineError> {
        // Only a load and a store: an error that slips in between repeats
        // what is reported anyway.
        let code = self.error.load(Ordering::Acquire);
        self.error.store(0, Ordering::Release);
        match code {
            0 => None,
            1 => Some(LineError::Overrun),
            2 => Some(LineError::Framing),
            _ => Some(LineError::Noise),
        }
    }
}

/// The part of a UART that differs between boards.
pub trait Line {
    /// Buffers of this line.
    fn buffers(&self) -> &Buffers;
    /// Starts sending bytes of the buffer.
    fn start_sending(&self);
    /// Whether the last stop bit has left.
    fn is_sent(&self) -> bool;
    /// Sets the speed in bits per second; called while nothing is being sent.
    fn set_baud(&self, baud: u32);
}

/// A line with `embedded-hal-nb` traits.
#[derive(Debug)]
pub struct Port<L>(pub L);

impl<L> ErrorType for Port<L> {
    type Error = LineError;
}

impl<L: Line> Read<u8> for Port<L> {
    fn read(&mut self) -> nb::Result<u8, LineError> {
        let buffers = self.0.buffers();
        if let Some(error) = buffers.take_error() {
            return Err(nb::Error::Other(error));
        }
        buffers.read().ok_or(nb::Error::WouldBlock)
    }
}

impl<L: Line> Write<u8> for Port<L> {
    fn write(&mut self, byte: u8) -> nb::Result<(), LineError> {
        if !self.0.buffers().write(byte) {
            return Err(nb::Error::WouldBlock);
        }
        self.0.start_sending();
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), LineError> {
        if self.0.is_sent() {
            Ok(())
        } else {
            Err(nb::Error::WouldBlock)
        }
    }
}

impl<L: Line> SetBaud for Port<L> {
    fn set_baud(&mut self, baud: u32) {
        self.0.set_baud(baud);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line that sends nothing.
    struct Stuck(Buffers);

    impl Line for Stuck {
        fn buffers(&self) -> &Buffers {
            &self.0
        }

        fn start_sending(&self) {}

        fn set_baud(&self, _baud: u32) {}

        fn is_sent(&self) -> bool {
            !self.0.is_sending()
        }
    }

    #[test]
    fn a_full_port_blocks_and_an_error_is_reported_once() {
        let mut port = Port(Stuck(Buffers::new()));
        assert_eq!(port.flush(), Ok(()));
        assert!((0..BUFFER_LEN).all(|_| port.write(0xFF).is_ok()));
        assert_eq!(port.write(0xFF), Err(nb::Error::WouldBlock));
        assert_eq!(port.flush(), Err(nb::Error::WouldBlock));

        // One byte more than there is room for, and its loss is reported first.
        assert_eq!(port.read(), Err(nb::Error::WouldBlock));
        (0..=BUFFER_LEN).for_each(|i| port.0.0.received(i as u8));
        assert_eq!(port.read(), Err(nb::Error::Other(LineError::Overrun)));
        assert!((0..BUFFER_LEN).all(|i| port.read() == Ok(i as u8)));
        assert_eq!(port.read(), Err(nb::Error::WouldBlock));
    }

    #[test]
    fn a_wait_ends_with_the_last_byte_expected_or_an_error() {
        let buffers = Buffers::new();
        let receive = |count| (0..count).map(|_| buffers.received(0)).count();
        // Nothing is expected: neither ends a wait.
        receive(3);
        buffers.report_error(LineError::Framing);
        assert!(!buffers.is_due());
        // The error is older than the wait, and its reader has not come for it.
        assert!(!buffers.expect(Some(4)));
        assert!(buffers.is_due());
        assert!(buffers.take_error().is_some() && !buffers.is_due());
        receive(1);
        assert!(buffers.is_due() && buffers.expect(Some(4)));
        assert!(!buffers.expect(Some(5)) && !buffers.is_due());
        buffers.report_error(LineError::Noise);
        assert!(buffers.is_due());
        // More than there is room for: a full buffer ends it.
        receive(BUFFER_LEN - 4);
        assert!(buffers.expect(Some(2 * BUFFER_LEN)));
        assert!(!buffers.expect(None));
    }
}
