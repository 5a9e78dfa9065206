//! Separation of our own echo from replies.
//!
//! On a single-wire bus whose receiver stays on, every byte sent is received
//! again. The stop sequence at the beginning of a search, to which no servo replies, shows
//! whether the bus echoes; from then on as many bytes as were sent are taken for echo,
//! and compared. The next search looks again: a disturbed line may have been taken for the
//! other kind.

/// Bytes of the last transmission that can be compared.
const SENT_MAX: usize = super::super::packet::REQUEST_MAX;

/// Echo of the bus, as observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum BusEcho {
    /// Not yet observed.
    #[default]
    Unknown,
    /// The receiver is off while we send.
    Silent,
    /// Every byte sent is received.
    Echoing,
}

/// Expected echo of the bytes sent since the last [`Echo::reset`].
#[derive(Debug, Default)]
pub(super) struct Echo {
    bus: BusEcho,
    /// The last transmission, or as much of it as fits.
    sent: heapless::Vec<u8, SENT_MAX>,
    /// Bytes sent since the last reset, and echo bytes received.
    sent_count: u32,
    received_count: u32,
    mismatch: bool,
}

impl Echo {
    /// Drops the bytes of earlier transmissions; call before sending.
    pub(super) fn reset(&mut self) {
        self.sent.clear();
        self.sent_count = 0;
        self.received_count = 0;
        self.mismatch = false;
    }

    /// Notes a byte that was sent.
    pub(super) fn note_sent(&mut self, byte: u8) {
        // Beyond the capacity only the count is checked.
        let _ = self.sent.push(byte);
        self.sent_count += 1;
    }

    /// Whether this received byte is echo. A byte in the place of echo that differs is
    /// counted as echo and recorded as a mismatch: another sender drove the wire.
    pub(super) fn is_echo(&mut self, byte: u8) -> bool {
        if self.bus == BusEcho::Silent || self.received_count >= self.sent_count {
            return false;
        }
        let expected = self.sent.get(self.received_count as usize);
        self.mismatch |= expected.is_some_and(|sent| *sent != byte);
        self.received_count += 1;
        true
    }

    /// Forgets whether the bus echoes; call before a transmission without a reply.
    pub(super) fn forget_bus(&mut self) {
        self.bus = BusEcho::Unknown;
    }

    /// Classifies an unknown bus, at the end of a transmission and its echo.
    pub(super) fn classify_bus(&mut self) {
        if self.bus == BusEcho::Unknown {
            let is_complete = self.received_count == self.sent_count;
            self.bus = if is_complete && !self.mismatch {
                BusEcho::Echoing
            } else {
                BusEcho::Silent
            };
        }
    }

    /// Whether the bus is known to echo.
    pub(super) fn is_echoing(&self) -> bool {
        self.bus == BusEcho::Echoing
    }

    /// Whether the echo of the last transmission differs from the bytes sent.
    pub(super) fn is_disturbed(&self) -> bool {
        self.is_echoing() && (self.mismatch || self.received_count < self.sent_count)
    }
}
