//! Decoder of the packets that a virtual servo with Dynamixel Protocol 1.0 or 2.0 receives.

use armbridge_servo::protocol::{PacketError, Parser, Protocol};

/// A pause inside a packet after which it is dropped (e-Manual, "Protocol 1.0"; that of Protocol
/// 2.0 is assumed to be the same).
const PAUSE_MAX_NS: u64 = 100_000_000;

/// The receive state machine, for packets of up to `N` bytes.
#[derive(Clone, Debug)]
pub(crate) struct PacketReceiver<P, const N: usize> {
    parser: Parser<P, N>,
    last_byte_ns: u64,
}

impl<P: Protocol, const N: usize> PacketReceiver<P, N> {
    pub(crate) fn new() -> Self {
        Self {
            parser: Parser::new(),
            last_byte_ns: 0,
        }
    }

    /// Processes a byte; returns the packet that it completes, intact or not. A byte without a
    /// stop bit discards the packet.
    pub(crate) fn push(
        &mut self,
        byte: u8,
        framing_error: bool,
        now_ns: u64,
    ) -> Option<Result<P::Frame<'_>, PacketError>> {
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
    pub(crate) fn begun(&self) -> &[u8] {
        let bytes = self.parser.bytes();
        bytes.get(..self.parser.bytes_held()).unwrap_or_default()
    }

    /// Adds a byte that this servo sends until `end_ns`.
    pub(crate) fn append(&mut self, byte: u8, end_ns: u64) {
        let _ = self.parser.push(byte);
        self.last_byte_ns = end_ns;
    }

    /// Discards an incomplete packet.
    pub(crate) fn clear(&mut self) {
        self.parser.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_servo::protocol1::Protocol1;

    type Receiver = PacketReceiver<Protocol1, 259>;

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
