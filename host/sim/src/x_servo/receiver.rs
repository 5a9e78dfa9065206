//! Decoder of packets: those of the master, and of the servos before this one in a chain.
//!
//! Limits that have no source: a packet has at most [`PACKET_MAX`] bytes, and one with a pause of
//! more than [`PAUSE_MAX_NS`] in it is dropped. So noise that looks like a header costs as many
//! bytes at most, or the time to the next pause. A part that this servo adds to a fast status
//! packet goes through its own decoder, or it would not find the end of the packet.

use armbridge_servo::protocol2::{Frame, PacketError, Parser};

/// Longest packet in bytes.
pub(super) const PACKET_MAX: usize = 512;
/// Longest pause inside a packet; that of Protocol 1.0.
const PAUSE_MAX_NS: u64 = 100_000_000;

/// The receive state machine.
#[derive(Clone, Debug)]
pub(super) struct Receiver {
    parser: Parser<PACKET_MAX>,
    last_byte_ns: u64,
}

impl Receiver {
    pub(super) fn new() -> Self {
        Self {
            parser: Parser::new(),
            last_byte_ns: 0,
        }
    }

    /// Processes a byte; returns the packet that it completes, intact or not. A byte without a
    /// stop bit discards the packet.
    pub(super) fn push(
        &mut self,
        byte: u8,
        framing_error: bool,
        now_ns: u64,
    ) -> Option<Result<Frame<'_>, PacketError>> {
        let pause_ns = now_ns.saturating_sub(self.last_byte_ns);
        self.last_byte_ns = now_ns;
        if pause_ns > PAUSE_MAX_NS || framing_error {
            self.parser.reset();
        }
        if framing_error {
            return None;
        }
        self.parser.push(byte)
    }

    /// Bytes of the packet that has begun.
    pub(super) fn begun(&self) -> &[u8] {
        let bytes = self.parser.bytes();
        bytes.get(..self.parser.bytes_held()).unwrap_or_default()
    }

    /// Adds a byte that this servo sends until `end_ns`.
    pub(super) fn append(&mut self, byte: u8, end_ns: u64) {
        let _ = self.parser.push(byte);
        self.last_byte_ns = end_ns;
    }

    /// Discards an incomplete packet.
    pub(super) fn clear(&mut self) {
        self.parser.reset();
    }
}
