//! Header, length, stuffing and CRC of a packet, in both directions.

use super::crc::checksum;
use crate::protocol;
use heapless::Vec;

/// First bytes of a packet; an FD in the place of the last is a stuffed parameter instead.
pub const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];
/// Destination of a packet to all servos, and the sender of a fast status packet.
pub const BROADCAST: u8 = 0xFE;
/// Largest id of a servo: 253 is never used, since it is part of the header.
pub const ID_MAX: u8 = 252;
/// Bytes of header, id and length.
pub(super) const HEAD: usize = 7;
/// Bytes of the CRC.
const CRC: usize = 2;
/// Sequence after which a byte is stuffed, and that byte.
pub(super) const MARK: [u8; 3] = [0xFF, 0xFF, 0xFD];
const STUFFING: u8 = 0xFD;
/// Code of a status packet.
pub const STATUS: u8 = 0x55;
/// Bytes of the shortest packet.
pub const OVERHEAD: usize = HEAD + 1 + CRC;

/// Dynamixel Protocol 2.0.
#[derive(Clone, Copy, Debug)]
pub struct Protocol2;

/// A packet without header, stuffing and CRC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Destination, or the servo that answers.
    pub id: u8,
    /// The instruction, 0x55 for a status packet.
    pub code: u8,
    /// Parameters; the first of a status packet is its error byte.
    pub parameters: &'a [u8],
}

impl Frame<'_> {
    /// The bytes on the wire; `None` if they are more than `N`.
    pub fn encode<const N: usize>(&self) -> Option<Vec<u8, N>> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(&HEADER).ok()?;
        bytes.extend_from_slice(&[self.id, 0, 0, self.code]).ok()?;
        for byte in self.parameters {
            bytes.push(*byte).ok()?;
            // The mark may begin with the instruction, but not before.
            if bytes.get(HEAD..)?.ends_with(&MARK) {
                bytes.push(STUFFING).ok()?;
            }
        }
        let length = u16::try_from(bytes.len() - HEAD + CRC).ok()?;
        bytes
            .get_mut(HEAD - 2..HEAD)?
            .copy_from_slice(&length.to_le_bytes());
        let crc = checksum(&bytes);
        bytes.extend_from_slice(&crc.to_le_bytes()).ok()?;
        Some(bytes)
    }
}

/// Removes the stuffing of a whole packet, and counts it out of its length. Whether all of it was
/// there. A fast status packet has none.
pub(super) fn unstuff<const N: usize>(packet: &mut Vec<u8, N>) -> bool {
    if is_fast(packet) {
        return true;
    }
    let end = packet.len().saturating_sub(CRC);
    let mut kept = HEAD;
    let mut before = [0; MARK.len()];
    for place in HEAD..end {
        let Some(&byte) = packet.get(place) else {
            return false;
        };
        let is_due = before == MARK;
        before = [before[1], before[2], byte];
        if is_due && byte != STUFFING {
            return false;
        }
        if let (false, Some(slot)) = (is_due, packet.get_mut(kept)) {
            *slot = byte;
            kept += 1;
        }
    }
    let removed = end.saturating_sub(kept);
    if before == MARK {
        return false;
    }
    if removed > 0 {
        packet.truncate(kept + CRC);
        let length = (packet.len() - HEAD) as u16;
        if let Some(bytes) = packet.get_mut(HEAD - 2..HEAD) {
            bytes.copy_from_slice(&length.to_le_bytes());
        }
    }
    true
}

/// Whether a packet is a fast status packet.
pub(super) fn is_fast(packet: &[u8]) -> bool {
    packet.get(HEADER.len()) == Some(&BROADCAST) && packet.get(HEAD) == Some(&STATUS)
}

/// Parser of packets of up to `N` bytes in a stream.
pub type Parser<const N: usize> = protocol::Parser<Protocol2, N>;

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::protocol::PacketError;
    use proptest::prelude::*;
    use std::vec::Vec as Bytes;

    fn parsed<const N: usize>(parser: &mut Parser<N>, bytes: &[u8]) -> Option<(u8, u8, Bytes<u8>)> {
        let mut found = None;
        for byte in bytes {
            if let Some(Ok(frame)) = parser.push(*byte) {
                found = Some((frame.id, frame.code, frame.parameters.to_vec()));
            }
        }
        found
    }

    /// Parameters that are rich in marks.
    fn parameters() -> impl Strategy<Value = Bytes<u8>> {
        let byte = prop_oneof![3 => Just(0xFF_u8), 3 => Just(0xFD_u8), 1 => any::<u8>()];
        proptest::collection::vec(byte, 0..60)
    }

    proptest! {
        #[test]
        fn every_frame_round_trips_behind_noise(
            noise in proptest::collection::vec(prop_oneof![Just(0xFF_u8), Just(0xFD_u8), Just(0_u8)], 0..12),
            id in 0..=ID_MAX,
            code in any::<u8>(),
            parameters in parameters(),
        ) {
            let frame = Frame { id, code, parameters: &parameters };
            let bytes = frame.encode::<160>().unwrap();
            let mut parser = Parser::<160>::new();
            prop_assert_eq!(parsed(&mut parser, &bytes), Some((id, code, parameters.clone())));
            // Noise may look like a header of a long packet, whose end the next ones are.
            for byte in noise {
                let _ = parser.push(byte);
            }
            let found = (0..40).find_map(|_| parsed(&mut parser, &bytes));
            prop_assert_eq!(found, Some((id, code, parameters)));
        }

        #[test]
        fn any_stream_is_survived_and_no_damage_passes(
            stream in proptest::collection::vec(any::<u8>(), 0..400),
            flip in 0..200_usize,
        ) {
            let mut parser = Parser::<64>::new();
            for byte in &stream {
                let _ = parser.push(*byte);
                prop_assert!(parser.bytes().len() <= 64);
            }
            let frame = Frame { id: 1, code: STATUS, parameters: &[0, 1, 2, 3] };
            let mut bytes = frame.encode::<32>().unwrap();
            let place = flip / 8 % bytes.len();
            bytes[place] ^= 1 << (flip % 8);
            parser.reset();
            prop_assert_eq!(parsed(&mut parser, &bytes), None);
        }
    }

    #[test]
    fn stuffing_is_that_of_the_e_manual() {
        let frame = Frame {
            id: 1,
            code: 3,
            parameters: &[0xFF, 0xFF, 0xFD, 0xFD, 0xFF],
        };
        let bytes = frame.encode::<32>().unwrap();
        assert_eq!(bytes[5..7], [9, 0]);
        assert_eq!(bytes[8..14], [0xFF, 0xFF, 0xFD, 0xFD, 0xFD, 0xFF]);
        assert_eq!(frame.encode::<15>(), None);
    }

    #[test]
    fn a_packet_without_its_stuffing_is_none() {
        let mut bytes = [0xFF, 0xFF, 0xFD, 0, 1, 6, 0, 3, 0xFF, 0xFF, 0xFD, 0, 0];
        let crc = checksum(&bytes[..11]);
        bytes[11..].copy_from_slice(&crc.to_le_bytes());
        let mut parser = Parser::<32>::new();
        let found = bytes.map(|byte| parser.push(byte).map(|it| it.map(|_| ())));
        assert_eq!(found[12], Some(Err(PacketError::Checksum { id: 1 })));
        assert_eq!(parser.bytes_held(), 0);
    }

    #[test]
    fn a_length_that_no_packet_has_ends_the_search() {
        let mut parser = Parser::<32>::new();
        for byte in [0xFF, 0xFF, 0xFD, 0x00, 1, 2] {
            assert_eq!(parser.push(byte), None);
        }
        assert_eq!(parser.push(0), Some(Err(PacketError::Header)));
        let ping = [0xFF, 0xFF, 0xFD, 0x00, 1, 3, 0, 1, 0x19, 0x4E];
        assert_eq!(parsed(&mut parser, &ping), Some((1, 1, Bytes::new())));
    }
}
