//! Separates our own echo from a reply.
//!
//! On a single-wire bus whose receiver stays on, every byte we send is received
//! again. Whether that is so is learnt from the first transmission, the stop
//! sequence, to which no servo replies; from then on as many bytes as were
//! sent are taken for echo, and compared.

/// Bytes of the last transmission that can be compared.
const MEMORY: usize = super::super::packet::REQUEST_MAX;

/// What has been learnt about the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum Bus {
    /// Nothing yet.
    #[default]
    Unknown,
    /// The receiver is off while we send.
    Silent,
    /// Every byte sent is received.
    Echoing,
}

/// Expected echo of what was sent since the last [`Echo::settle`].
#[derive(Debug, Default)]
pub(super) struct Echo {
    bus: Bus,
    /// The last transmission, or as much of it as fits.
    sent: heapless::Vec<u8, MEMORY>,
    /// Bytes sent, and received, since the last settling.
    sent_count: u32,
    heard_count: u32,
    mismatch: bool,
}

impl Echo {
    /// Forgets the bytes of earlier transmissions; call before sending.
    pub(super) fn begin(&mut self) {
        self.sent.clear();
        self.sent_count = 0;
        self.heard_count = 0;
        self.mismatch = false;
    }

    /// A byte went out.
    pub(super) fn sent(&mut self, byte: u8) {
        // Beyond the memory the count alone is checked.
        let _ = self.sent.push(byte);
        self.sent_count += 1;
    }

    /// Whether this byte is our own. One that should be ours but differs is
    /// counted as ours and remembered: another sender drove the wire.
    pub(super) fn claims(&mut self, byte: u8) -> bool {
        if self.bus == Bus::Silent || self.heard_count >= self.sent_count {
            return false;
        }
        let expected = self.sent.get(self.heard_count as usize);
        self.mismatch |= expected.is_some_and(|sent| *sent != byte);
        self.heard_count += 1;
        true
    }

    /// The transmission is over and its echo, if any, has arrived.
    pub(super) fn settle(&mut self) {
        if self.bus == Bus::Unknown {
            let all = self.heard_count == self.sent_count;
            self.bus = if all && !self.mismatch {
                Bus::Echoing
            } else {
                Bus::Silent
            };
        }
    }

    /// Whether the bus is known to echo.
    pub(super) fn is_echoing(&self) -> bool {
        self.bus == Bus::Echoing
    }

    /// Whether the echo of the last transmission was not what was sent.
    pub(super) fn is_disturbed(&self) -> bool {
        self.is_echoing() && (self.mismatch || self.heard_count < self.sent_count)
    }
}
