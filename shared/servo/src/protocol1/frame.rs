//! Frame of instruction and status packets: header, length and checksum.

use crate::protocol;
use heapless::Vec;

/// Header byte; each packet begins with two of them.
pub const HEADER: u8 = 0xFF;
/// Id of a packet to all servos. Ids of servos are 0..=253.
pub const BROADCAST: u8 = 0xFE;
/// Bytes of a packet beside its parameters.
pub const OVERHEAD: usize = 6;
/// Bytes of the longest packet: LEN of 255.
pub const FRAME_MAX: usize = 4 + 255;

/// Dynamixel Protocol 1.0.
#[derive(Clone, Copy, Debug)]
pub struct Protocol1;

/// An intact packet, borrowed from a parser or to be encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Id of the servo that is addressed, or that answers; [`BROADCAST`] for all.
    pub id: u8,
    /// Instruction, or error byte.
    pub code: u8,
    /// Parameters.
    pub parameters: &'a [u8],
}

/// Complement of the sum of `body`, modulo 256.
pub fn checksum(body: &[u8]) -> u8 {
    !body.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
}

impl Frame<'_> {
    /// The bytes on the wire; `None` if they are more than `N`, or than a
    /// packet can be.
    pub fn encode<const N: usize>(&self) -> Option<Vec<u8, N>> {
        let mut bytes = Vec::new();
        let length = u8::try_from(self.parameters.len() + 2).ok()?;
        let head = [HEADER, HEADER, self.id, length, self.code];
        bytes.extend_from_slice(&head).ok()?;
        bytes.extend_from_slice(self.parameters).ok()?;
        let sum = checksum(bytes.get(2..)?);
        bytes.push(sum).ok()?;
        Some(bytes)
    }
}

/// Parser of packets of up to `N` bytes in a stream.
pub type Parser<const N: usize> = protocol::Parser<Protocol1, N>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::PacketError;
    use proptest::prelude::*;

    type Long = Parser<FRAME_MAX>;

    proptest! {
        /// Whatever is encoded is found again, even after garbage, unless that
        /// ends in what begins a packet.
        #[test]
        fn frames_are_found_after_garbage(
            garbage in proptest::collection::vec(0..=0xFE_u8, 0..40),
            id in 0..=BROADCAST,
            code: u8,
            parameters in proptest::collection::vec(any::<u8>(), 0..=253),
        ) {
            let frame = Frame { id, code, parameters: &parameters };
            let bytes = frame.encode::<FRAME_MAX>().unwrap();
            let mut parser = Long::new();
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
        /// nothing is needed before packets are found again.
        #[test]
        fn parser_resynchronises_within_one_packet(
            garbage in proptest::collection::vec(any::<u8>(), 0..300),
        ) {
            const SHORT: usize = 16;
            let ping = Frame { id: 1, code: 0, parameters: &[] };
            let bytes = ping.encode::<SHORT>().unwrap();
            let mut parser = Parser::<SHORT>::new();
            for byte in garbage {
                let _ = parser.push(byte);
            }
            // The header of the garbage may swallow this many of them.
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
    fn damage_is_named() {
        let mut parser = Long::new();
        let results: heapless::Vec<_, 4> = [0xFF, 0xFF, 0xFF, 7, 2, 0, 0xF7, 0xFF, 0xFF, 1, 0]
            .into_iter()
            .filter_map(|byte| parser.push(byte).map(|result| result.map(|frame| frame.id)))
            .collect();
        assert_eq!(
            results,
            [
                Err(PacketError::Checksum { id: 7 }),
                Err(PacketError::Header)
            ]
        );
    }
}
