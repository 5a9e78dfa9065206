//! Decoder of instruction packets.

use armbridge_servo::protocol1::frame::FRAME_MAX;
use armbridge_servo::protocol1::{Frame, PacketError, Parser};

/// A pause inside a packet after which it is dropped (e-Manual, "Protocol 1.0").
const PAUSE_MAX_NS: u64 = 100_000_000;

/// The receive state machine.
#[derive(Clone, Debug)]
pub(super) struct Receiver {
    parser: Parser<FRAME_MAX>,
    last_byte_ns: u64,
}

impl Receiver {
    pub(super) fn new() -> Self {
        Self {
            parser: Parser::new(),
            last_byte_ns: 0,
        }
    }

    /// Processes a byte; returns the packet that it completes, intact or with a wrong
    /// checksum. A byte without a stop bit discards the packet.
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

    /// Discards an incomplete packet.
    pub(super) fn clear(&mut self) {
        self.parser.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PING: [u8; 6] = [0xFF, 0xFF, 1, 2, 1, 0xFB];

    /// Pings found among these bytes, with `pause_ns` before byte `at`.
    fn pings(bytes: &[u8], at: usize, pause_ns: u64) -> usize {
        let (mut receiver, mut now_ns, mut found) = (Receiver::new(), 0, 0);
        for (index, byte) in bytes.iter().enumerate() {
            now_ns += if index == at { pause_ns } else { 10_000 };
            found += usize::from(matches!(receiver.push(*byte, false, now_ns), Some(Ok(_))));
        }
        found
    }

    #[test]
    fn a_pause_of_more_than_100_ms_drops_the_packet() {
        assert_eq!(pings(&PING, 4, 100_000_000), 1);
        assert_eq!(pings(&PING, 4, 100_000_001), 0);
        // And the header that comes after it begins the next.
        let bytes = [&PING[..4], &PING].concat();
        assert_eq!(pings(&bytes, 4, 150_000_000), 1);
    }

    #[test]
    fn a_framing_error_is_no_byte() {
        let mut receiver = Receiver::new();
        for byte in &PING[..5] {
            assert!(receiver.push(*byte, false, 0).is_none());
        }
        assert!(receiver.push(PING[5], true, 0).is_none());
        assert!(receiver.push(PING[5], false, 0).is_none());
    }
}
