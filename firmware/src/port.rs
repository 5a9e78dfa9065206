//! Buffers between the interrupt handler of a UART and the code that uses it.
//!
//! # Waking
//!
//! A reply of the servos is 14 bytes, 10 µs apart, and the master can do nothing
//! before the last of them. It announces how many it waits for ([`Buffers::wake_after`]), and
//! the interrupt handler wakes it at this count, or when the receiver reports an
//! error ([`Buffers::is_due`]): once a reply, not once a byte, which costs a poll each,
//! some 700 instructions. Bytes that it does not expect, echo or noise on
//! an idle line, stay in the buffer until its next poll.

use crate::ring::ByteRing;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering, compiler_fence};
use embedded_hal_nb::serial::ErrorKind;

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
    pub fn wake_after(&self, bytes: Option<usize>) -> bool {
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

    /// Takes the last error of the receiver.
    pub fn take_error(&self) -> Option<LineError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_buffer_refuses_and_an_error_is_reported_once() {
        let buffers = Buffers::new();
        assert!(!buffers.is_sending());
        assert!((0..BUFFER_LEN).all(|_| buffers.write(0xFF)));
        assert!(!buffers.write(0xFF) && buffers.is_sending());

        // One byte more than there is room for.
        (0..=BUFFER_LEN).for_each(|i| buffers.received(i as u8));
        assert_eq!(buffers.take_error(), Some(LineError::Overrun));
        assert_eq!(buffers.take_error(), None);
        assert!((0..BUFFER_LEN).all(|i| buffers.read() == Some(i as u8)));
        assert_eq!(buffers.read(), None);
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
        assert!(!buffers.wake_after(Some(4)));
        assert!(buffers.is_due());
        assert!(buffers.take_error().is_some() && !buffers.is_due());
        receive(1);
        assert!(buffers.is_due() && buffers.wake_after(Some(4)));
        assert!(!buffers.wake_after(Some(5)) && !buffers.is_due());
        buffers.report_error(LineError::Noise);
        assert!(buffers.is_due());
        // More than there is room for: a full buffer ends it.
        receive(BUFFER_LEN - 4);
        assert!(buffers.wake_after(Some(2 * BUFFER_LEN)));
        assert!(!buffers.wake_after(None));
    }
}
