//! Fast status packet: the joint reply of several servos to a fast read.
//!
//! Each servo adds its part as soon as the one before has sent its own. The CRC after a part is that
//! of all bytes so far, so that the parts that have come are certain even if a servo is silent, and
//! the packet never ends.

use super::crc::Crc;
use super::frame::{BROADCAST, HEADER, STATUS};
use super::status::{StatusError, decode_error, encode_error};
use heapless::Vec;

/// Bytes before the first part: header, id, length, code.
const HEAD: usize = 8;
/// Bytes of a part beside its data: error byte, id, CRC.
const BESIDE: usize = 4;

/// The answer of one servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part<'a> {
    /// Id of the servo.
    pub id: u8,
    /// A hardware error is latched.
    pub is_alert: bool,
    /// Why it did not carry out the instruction.
    pub error: Option<StatusError>,
    /// Contents of the registers.
    pub data: &'a [u8],
}

/// Reason why the parts end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartError {
    /// The CRC up to this part is wrong: neither it nor a later one can be trusted.
    Crc,
}

/// The parts of a fast status packet, as far as they have been received.
#[derive(Clone, Debug)]
pub struct FastStatus<'a> {
    rest: &'a [u8],
    count: usize,
    crc: Crc,
}

impl<'a> FastStatus<'a> {
    /// Takes bytes from the header on, of which there may be fewer than the packet has; each part
    /// has `count` bytes of data. `None` if they are no beginning of a fast status packet.
    pub fn new(bytes: &'a [u8], count: usize) -> Option<Self> {
        let (head, rest) = bytes.split_at_checked(HEAD)?;
        let is_fast = head.starts_with(&HEADER)
            && head.get(HEADER.len()) == Some(&BROADCAST)
            && head.last() == Some(&STATUS);
        let mut crc = Crc::new();
        crc.update(head);
        is_fast.then_some(Self { rest, count, crc })
    }

    /// Bytes of a packet of so many servos.
    pub const fn packet_bytes(servos: usize, count: usize) -> usize {
        HEAD + servos * (BESIDE + count)
    }

    /// The packet of these parts, all with `count` bytes; `None` if it is longer than `N`.
    pub fn encode<const N: usize>(parts: &[Part<'_>], count: usize) -> Option<Vec<u8, N>> {
        let length = Self::packet_bytes(parts.len(), count);
        let mut bytes: Vec<u8, N> = Vec::from_slice(&Self::encode_head(length)?).ok()?;
        for part in parts.iter().filter(|part| part.data.len() == count) {
            let part = part.encode::<N>(&bytes)?;
            bytes.extend_from_slice(&part).ok()?;
        }
        Some(bytes)
    }

    /// The bytes before the first part of a packet of so many bytes in all; `None` if no packet has
    /// this length.
    pub fn encode_head(packet_bytes: usize) -> Option<[u8; HEAD]> {
        let length = u16::try_from(packet_bytes.checked_sub(HEAD - 1)?).ok()?;
        let [low, high] = length.to_le_bytes();
        let [a, b, c, d] = HEADER;
        Some([a, b, c, d, BROADCAST, low, high, STATUS])
    }
}

impl Part<'_> {
    /// Its bytes in a packet of which these are sent already; `None` if they are more than `N`.
    pub fn encode<const N: usize>(&self, before: &[u8]) -> Option<Vec<u8, N>> {
        let mut bytes = Vec::new();
        let error = encode_error(self.is_alert, self.error);
        bytes.extend_from_slice(&[error, self.id]).ok()?;
        bytes.extend_from_slice(self.data).ok()?;
        let mut crc = Crc::new();
        crc.update(before);
        crc.update(&bytes);
        bytes.extend_from_slice(&crc.value().to_le_bytes()).ok()?;
        Some(bytes)
    }
}

impl<'a> Iterator for FastStatus<'a> {
    type Item = Result<Part<'a>, PartError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (part, rest) = self.rest.split_at_checked(BESIDE + self.count)?;
        self.rest = rest;
        let (body, crc) = part.split_at_checked(part.len() - 2)?;
        self.crc.update(body);
        if *crc != self.crc.value().to_le_bytes() {
            self.rest = &[];
            return Some(Err(PartError::Crc));
        }
        self.crc.update(crc);
        let &[error, id, ref data @ ..] = body else {
            return None;
        };
        let (is_alert, error) = decode_error(error);
        Some(Ok(Part {
            id,
            is_alert,
            error,
            data,
        }))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::Parser;
    use super::*;
    use std::vec::Vec as Parts;

    fn part(id: u8, data: &[u8]) -> Part<'_> {
        Part {
            id,
            is_alert: false,
            error: None,
            data,
        }
    }

    #[test]
    fn parts_are_certain_as_they_come() {
        // Marks in the data: nothing is stuffed.
        let parts = [part(1, &[0xFF, 0xFF, 0xFD, 0]), part(2, &[4, 5, 6, 7])];
        let bytes = FastStatus::encode::<64>(&parts, 4).unwrap();
        assert_eq!(bytes.len(), FastStatus::packet_bytes(2, 4));
        let found: Parts<_> = FastStatus::new(&bytes, 4).unwrap().collect();
        assert_eq!(found, [Ok(parts[0]), Ok(parts[1])]);
        // The second servo is silent.
        let first = &bytes[..FastStatus::packet_bytes(1, 4) + 3];
        let found: Parts<_> = FastStatus::new(first, 4).unwrap().collect();
        assert_eq!(found, [Ok(parts[0])]);
        // Damage of the first part spoils both.
        let mut damaged = bytes.clone();
        damaged[10] ^= 1;
        let found: Parts<_> = FastStatus::new(&damaged, 4).unwrap().collect();
        assert_eq!(found, [Err(PartError::Crc)]);
        // The parser finds its end by length and CRC.
        let mut parser = Parser::<64>::new();
        let (last, before) = bytes.split_last().unwrap();
        for byte in before {
            assert_eq!(parser.push(*byte), None);
        }
        assert!(parser.push(*last).unwrap().is_ok());
        assert_eq!(parser.bytes(), bytes);
    }

    #[test]
    fn no_other_packet_is_a_fast_status() {
        let ping = [
            0xFF, 0xFF, 0xFD, 0, 1, 7, 0, 0x55, 0, 6, 4, 0x26, 0x65, 0x5D,
        ];
        assert!(FastStatus::new(&ping, 3).is_none());
        assert!(FastStatus::new(&[], 3).is_none());
    }
}
