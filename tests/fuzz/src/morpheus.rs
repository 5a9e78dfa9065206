//! Packets of Morpheus servos, and the bridge's decoding of replies.

use armbridge_servo::morpheus::frame::{FRAME_MAX, LENGTH_MAX, Parser};
use armbridge_servo::morpheus::{HEADER, MASTER, Morpheus, PacketError, checksum};
use armbridge_servo::protocol::Protocol;

use super::packets::{Found, Packets, feed};

/// Reply of servo 1 to PING, as recorded.
const ANSWER: [u8; 6] = [HEADER, 3, MASTER, 1, 1, 0xF9];
/// Begins no packet, and completes any that has begun. It also flushes the firmware's own
/// receiver.
const NEUTRAL: u8 = 0xFF;
/// Bytes of the longest reply that the bridge asks for.
const REPLY: usize = 7;

/// Feeds parsers for packets of up to 7, 16 and all the bytes there can be,
/// and for replies to the master only, and counts what they find.
///
/// # Panics
/// If one of them does what it must not.
pub fn check(input: &[u8]) -> usize {
    feed(Addressed::<REPLY>::any(), input, NEUTRAL, &ANSWER)
        + feed(Addressed::<16>::any(), input, NEUTRAL, &ANSWER)
        + feed(Addressed::<FRAME_MAX>::any(), input, NEUTRAL, &ANSWER)
        + feed(Addressed::<REPLY>::to_master(), input, NEUTRAL, &ANSWER)
}

/// A parser of packets of up to `N` bytes, to one address or to any.
struct Addressed<const N: usize> {
    parser: Parser<N>,
    address: Option<u8>,
}

impl<const N: usize> Addressed<N> {
    fn any() -> Self {
        Self {
            parser: Parser::new(),
            address: None,
        }
    }

    fn to_master() -> Self {
        Self {
            parser: Parser::to(MASTER),
            address: Some(MASTER),
        }
    }
}

impl<const N: usize> Packets for Addressed<N> {
    fn push(&mut self, byte: u8) -> Option<Found> {
        push(&mut self.parser, byte)
    }

    fn bytes_held(&self) -> usize {
        self.parser.bytes_held()
    }

    fn longest(&self) -> usize {
        N
    }

    fn intact(&self, bytes: &[u8]) -> Option<usize> {
        let is_addressed = |address| bytes[2] == address;
        intact(bytes).filter(|len| *len <= N && self.address.is_none_or(is_addressed))
    }
}

fn push<const N: usize>(parser: &mut Parser<N>, byte: u8) -> Option<Found> {
    Some(match parser.push(byte)? {
        Ok(frame) => {
            let bytes = frame.encode::<N>().expect("it came out of a parser");
            let reply = Morpheus::reply(&frame).expect("servos send anything");
            assert_eq!((reply.id, reply.data), (frame.source, frame.data));
            assert_eq!(Morpheus::is_pong(reply.data), frame.data == [1]);
            let counts = Morpheus::position(reply.data);
            assert!(counts.is_none_or(|counts| counts.to_be_bytes() == *frame.data));
            assert_eq!(counts.is_some(), frame.data.len() == 2 && frame.data[0] < 4);
            Found::Intact(bytes.to_vec())
        }
        Err(PacketError::Checksum { .. }) => Found::Damaged,
        Err(PacketError::Header) => Found::Refused,
    })
}

/// Length of the intact packet that these bytes begin with.
fn intact(bytes: &[u8]) -> Option<usize> {
    let [HEADER, length @ 3..=LENGTH_MAX, ..] = bytes else {
        return None;
    };
    let len = usize::from(*length) + 3;
    let (sum, body) = bytes.get(1..len)?.split_last()?;
    (checksum(body) == *sum).then_some(len)
}
