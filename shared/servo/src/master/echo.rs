//! Separation of our own echo from replies.
//!
//! On a single-wire bus whose receiver stays on, every byte sent is received
//! again. The stop sequence at the beginning of a search, to which no servo replies, shows
//! whether the bus echoes; from then on as many bytes as were sent are taken for echo,
//! and compared. The next search looks again: a disturbed line may have been taken for the
//! other kind.

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

/// Expected echo of the last transmission.
#[derive(Debug, Default)]
pub(super) struct Echo {
    bus: BusEcho,
    /// Bytes of the transmission, and echo bytes received.
    sent: usize,
    received: usize,
    mismatch: bool,
}

impl Echo {
    /// Notes a transmission of this many bytes, and drops the one before.
    pub(super) fn begin(&mut self, sent: usize) {
        self.sent = sent;
        self.received = 0;
        self.mismatch = false;
    }

    /// Received bytes without the echo of `sent`, the last transmission, at their beginning.
    /// A byte in the place of echo that differs is counted as echo and recorded as a mismatch:
    /// another sender drove the wire.
    pub(super) fn strip<'a>(&mut self, bytes: &'a [u8], sent: &[u8]) -> &'a [u8] {
        let due = if self.bus == BusEcho::Silent {
            0
        } else {
            self.sent.saturating_sub(self.received)
        };
        let Some((echo, rest)) = bytes.split_at_checked(due.min(bytes.len())) else {
            return bytes;
        };
        let expected = sent.get(self.received..).unwrap_or_default();
        self.mismatch |= echo.iter().zip(expected).any(|(echo, sent)| echo != sent);
        self.received += echo.len();
        rest
    }

    /// Bytes of echo that are still to come, from a bus that is known to echo.
    pub(super) fn bytes_due(&self) -> usize {
        if self.is_echoing() {
            self.sent.saturating_sub(self.received)
        } else {
            0
        }
    }

    /// Forgets whether the bus echoes; call before a transmission without a reply.
    pub(super) fn forget_bus(&mut self) {
        self.bus = BusEcho::Unknown;
    }

    /// Classifies an unknown bus, at the end of a transmission and its echo.
    pub(super) fn classify_bus(&mut self) {
        if self.bus == BusEcho::Unknown {
            let is_complete = self.received == self.sent;
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
        self.is_echoing() && (self.mismatch || self.received < self.sent)
    }
}
