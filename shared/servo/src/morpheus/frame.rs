//! Frame of requests and replies: header, length and checksum.

use crate::protocol;
use heapless::Vec;

/// First byte of every packet.
pub const HEADER: u8 = 0xAA;
/// Destination that every servo takes for its own.
pub const BROADCAST: u8 = 0xFF;
/// Bytes of a packet beside its data.
pub const OVERHEAD: usize = 5;
/// Smallest LEN: destination, source and one byte.
pub(super) const LENGTH_MIN: u8 = 3;
/// Largest LEN that does not silence a servo until power-off.
pub const LENGTH_MAX: u8 = 127;
/// Largest LEN that a servo accepts.
pub(super) const LENGTH_HEARD_MAX: u8 = 200;
/// Bytes of the longest packet with a LEN of up to [`LENGTH_MAX`].
pub const FRAME_MAX: usize = LENGTH_MAX as usize + 3;

/// The protocol of the Morpheus firmware.
#[derive(Clone, Copy, Debug)]
pub struct Morpheus;

/// An intact packet, borrowed from a parser or to be encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Receiver: a servo, the master, or [`BROADCAST`].
    pub destination: u8,
    /// Sender.
    pub source: u8,
    /// Command and parameters, or a reply's payload. At least one byte.
    pub data: &'a [u8],
}

/// Sum of the complements of `body`, modulo 256.
pub fn checksum(body: &[u8]) -> u8 {
    body.iter().fold(0, |sum: u8, byte| sum.wrapping_add(!byte))
}

impl Frame<'_> {
    /// The bytes on the wire; `None` if they are more than `N`, if LEN would be
    /// above [`LENGTH_MAX`], or if the data are empty.
    pub fn encode<const N: usize>(&self) -> Option<Vec<u8, N>> {
        let length = u8::try_from(self.data.len() + 2).ok()?;
        if !(LENGTH_MIN..=LENGTH_MAX).contains(&length) {
            return None;
        }
        let mut bytes = Vec::new();
        let head = [HEADER, length, self.destination, self.source];
        bytes.extend_from_slice(&head).ok()?;
        bytes.extend_from_slice(self.data).ok()?;
        let sum = checksum(bytes.get(1..)?);
        bytes.push(sum).ok()?;
        Some(bytes)
    }
}

/// Parser of packets of up to `N` bytes in a stream.
pub type Parser<const N: usize> = protocol::Parser<Morpheus, N>;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever is encoded is found again, even after garbage, unless that
        /// holds what begins a packet.
        #[test]
        fn frames_are_found_after_garbage(
            garbage in proptest::collection::vec(0..HEADER, 0..40),
            destination: u8,
            source: u8,
            data in proptest::collection::vec(any::<u8>(), 1..=125),
        ) {
            let frame = Frame { destination, source, data: &data };
            let bytes = frame.encode::<FRAME_MAX>().unwrap();
            let mut parser = Parser::<FRAME_MAX>::new();
            for byte in garbage {
                prop_assert_eq!(parser.push(byte), None);
            }
            let (last, before) = bytes.split_last().unwrap();
            for byte in before {
                prop_assert_eq!(parser.push(*byte), None);
            }
            prop_assert_eq!(parser.push(*last), Some(Ok(frame)));
            prop_assert_eq!(parser.bytes_held(), 0);
        }

        /// After any bytes at all, no more than a longest packet's worth of
        /// packets is lost.
        #[test]
        fn parser_resynchronises_within_one_packet(
            garbage in proptest::collection::vec(any::<u8>(), 0..300),
        ) {
            const SHORT: usize = 16;
            let ping = Frame { destination: 0xFE, source: 1, data: &[1] };
            let bytes = ping.encode::<SHORT>().unwrap();
            let mut parser = Parser::<SHORT>::new();
            for byte in garbage {
                let _ = parser.push(byte);
            }
            let mut found = 0;
            for _ in 0..=SHORT / bytes.len() + 1 {
                for byte in &bytes {
                    found += usize::from(matches!(parser.push(*byte), Some(Ok(frame)) if frame == ping));
                }
            }
            prop_assert!(found >= 1);
        }
    }

    #[test]
    fn lengths_that_silence_a_servo_are_not_encoded() {
        let frame = |data| Frame {
            destination: 1,
            source: 0xFE,
            data,
        };
        assert_eq!(frame(&[]).encode::<200>(), None);
        assert_eq!(frame(&[0; 126]).encode::<200>(), None);
        assert!(frame(&[0; 125]).encode::<200>().is_some());
    }
}
