//! Header, length and checksum: what requests and replies share.

use heapless::Vec;

/// First byte of every packet.
pub const HEADER: u8 = 0xAA;
/// Destination that every servo takes for its own.
pub const BROADCAST: u8 = 0xFF;
/// Bytes of a packet beside its data.
pub const OVERHEAD: usize = 5;
/// Largest LEN that does not silence a servo until power-off.
pub const LENGTH_MAX: u8 = 127;
/// Bytes of the longest packet with such a LEN.
pub const FRAME_MAX: usize = LENGTH_MAX as usize + 3;

/// An intact packet, borrowed from a parser or to be encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Who shall take it: a servo, the master, or [`BROADCAST`].
    pub destination: u8,
    /// Who sent it.
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
    /// above [`LENGTH_MAX`], or if there is nothing in it.
    pub fn encode<const N: usize>(&self) -> Option<Vec<u8, N>> {
        let length = u8::try_from(self.data.len() + 2).ok()?;
        if !(3..=LENGTH_MAX).contains(&length) {
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

/// Why bytes are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// A wrong checksum.
    Checksum {
        /// The source it came with, for what that is worth.
        source: u8,
    },
    /// A length that no expected packet has, or somebody else's packet.
    Header,
}

/// Finds packets in a stream of bytes, one byte at a time, of up to `N` bytes.
///
/// Bytes before a header are skipped. After a damaged packet the search goes on
/// with the next byte, so that garbage costs one packet at the most: the one
/// that its last header swallowed.
#[derive(Clone, Debug)]
pub struct Parser<const N: usize> {
    bytes: Vec<u8, N>,
    /// The only destination that is believed; `None` for any.
    only_to: Option<u8>,
}

impl<const N: usize> Parser<N> {
    /// A parser for packets to anybody.
    pub const fn any() -> Self {
        Self {
            bytes: Vec::new(),
            only_to: None,
        }
    }

    /// A parser for packets to this address only. It falls for fewer stray
    /// headers.
    pub const fn to(address: u8) -> Self {
        Self {
            bytes: Vec::new(),
            only_to: Some(address),
        }
    }

    /// Takes one byte; `Some` when it ends a packet, or what looked like one.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame<'_>, Damage>> {
        if self.ends() {
            self.bytes.clear();
        }
        let is_plausible = match self.bytes.len() {
            0 if byte != HEADER => return None,
            1 => (3..=LENGTH_MAX).contains(&byte) && usize::from(byte) + 3 <= N,
            2 => self.only_to.is_none_or(|address| address == byte),
            _ => true,
        };
        if !is_plausible {
            self.bytes.clear();
            // What broke the packet may begin the next one.
            if byte == HEADER {
                let _ = self.bytes.push(byte);
            }
            return Some(Err(Damage::Header));
        }
        // There is room: a length beyond N was refused.
        let _ = self.bytes.push(byte);
        if !self.ends() {
            return None;
        }
        let [_, _, destination, source, data @ .., sum] = self.bytes.as_slice() else {
            return None;
        };
        let body = self.bytes.get(1..self.bytes.len() - 1).unwrap_or_default();
        Some(if checksum(body) == *sum {
            Ok(Frame {
                destination: *destination,
                source: *source,
                data,
            })
        } else {
            Err(Damage::Checksum { source: *source })
        })
    }

    /// The last byte pushed was the last of a packet.
    fn ends(&self) -> bool {
        matches!(self.bytes.get(1), Some(length) if self.bytes.len() == usize::from(*length) + 3)
    }

    /// Bytes of a packet that has begun and not ended.
    pub fn bytes_held(&self) -> usize {
        if self.ends() { 0 } else { self.bytes.len() }
    }

    /// Forgets a packet that has begun.
    pub fn reset(&mut self) {
        self.bytes.clear();
    }
}

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
            let mut parser = Parser::<FRAME_MAX>::any();
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
            let mut parser = Parser::<SHORT>::any();
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
