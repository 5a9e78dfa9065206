//! Frames: messages on a stream of bytes.
//!
//! ```text
//! COBS( version u8 | direction u8 | sequence u16 | postcard message | CRC-32 ) 0x00
//! ```
//!
//! Integers are little endian. The zero byte occurs nowhere but at the end of a
//! frame, so a receiver that joins late or loses bytes is back in step at the
//! next zero. A frame whose sequence number is not the one after its
//! predecessor's says how many were lost; the number 0, out of turn, that the sender
//! began anew, and nobody knows what it had said meanwhile.

use cobs::{DecodeResult, DecoderState};
use postcard::experimental::max_size::MaxSize;
use serde::{Serialize, de::DeserializeOwned};

use super::message::{ToBoard, ToHost};
use crate::crc32;

/// Version of the frame layout.
const VERSION: u8 = 1;
const HEADER: usize = 4;
const CRC_LEN: usize = 4;

/// Longest frame of any message, terminator included: COBS adds a byte, and
/// another for every 254.
pub const MAX: usize = {
    let (board, host) = (ToBoard::POSTCARD_MAX_SIZE, ToHost::POSTCARD_MAX_SIZE);
    let plain = HEADER + CRC_LEN + if board > host { board } else { host };
    plain + 1 + plain / 254 + 1
};

/// A message that travels in one direction.
pub trait Message: Serialize + DeserializeOwned + MaxSize {
    /// Tells the directions apart, so that an end that hears itself knows.
    const DIRECTION: u8;
}

impl Message for ToBoard {
    const DIRECTION: u8 = b'B';
}

impl Message for ToHost {
    const DIRECTION: u8 = b'H';
}

/// Makes frames of messages.
#[derive(Clone, Debug)]
pub struct Encoder {
    sequence: u16,
    frame: [u8; MAX],
}

impl Default for Encoder {
    fn default() -> Self {
        Self {
            sequence: 0,
            frame: [0; MAX],
        }
    }
}

impl Encoder {
    /// The frame for `message` and its sequence number.
    pub fn encode<M: Message>(&mut self, message: &M) -> (u16, &[u8]) {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        // Buffers hold the longest message there is (`MAX`), so that this is
        // never empty; if it were, the receiver would count a lost frame.
        let len = Self::write(&mut self.frame, message, sequence).unwrap_or(0);
        (sequence, self.frame.get(..len).unwrap_or_default())
    }

    fn write<M: Message>(frame: &mut [u8; MAX], message: &M, sequence: u16) -> Option<usize> {
        let mut plain = [0; MAX];
        let [low, high] = sequence.to_le_bytes();
        let (header, rest) = plain.split_first_chunk_mut::<HEADER>()?;
        *header = [VERSION, M::DIRECTION, low, high];
        let body = postcard::to_slice(message, rest).ok()?.len();
        let crc = crc32::checksum(plain.get(..HEADER + body)?);
        plain
            .get_mut(HEADER + body..)?
            .first_chunk_mut()
            .map(|to| *to = crc.to_le_bytes())?;
        let plain = plain.get(..HEADER + body + CRC_LEN)?;
        let len = cobs::try_encode(plain, frame.get_mut(..MAX - 1)?).ok()?;
        *frame.get_mut(len)? = 0;
        Some(len + 1)
    }
}

/// Why a frame was not understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Truncated, longer than [`MAX`], or a wrong CRC.
    Damaged,
    /// Another layout version than this build's.
    Version(u8),
    /// Intact, but travelling the other way: our own echo, or two hosts.
    Direction,
    /// Intact, but not a message of this build: another schema.
    Schema,
}

/// A message, the number of its frame, and how many went missing before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received<M> {
    /// What was said.
    pub message: M,
    /// Sequence number of the frame.
    pub sequence: u16,
    /// Frames lost since the previous intact one; 0 if the sender began anew.
    pub lost: u16,
}

/// What a frame of [`MAX`] bytes can hold at the most: COBS adds at least one, and
/// then there is the terminator.
const PLAIN_MAX: usize = MAX - 2;

/// Finds frames in a stream, one byte at a time.
#[derive(Debug)]
pub struct Decoder {
    cobs: DecoderState,
    plain: [u8; PLAIN_MAX],
    len: usize,
    next: Option<u16>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            cobs: DecoderState::default(),
            plain: [0; PLAIN_MAX],
            len: 0,
            next: None,
        }
    }
}

impl Decoder {
    /// Takes one byte; `Some` when it ends a frame.
    pub fn push<M: Message>(&mut self, byte: u8) -> Option<Result<Received<M>, FrameError>> {
        match self.cobs.feed(byte) {
            // Two terminators in a row are no frame, but sent to get into step.
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataStart) => {
                self.len = 0;
                None
            }
            Ok(DecodeResult::DataContinue(byte)) => {
                if let Some(slot) = self.plain.get_mut(self.len) {
                    *slot = byte;
                }
                // Past the end: remember that it was too long, never wrap.
                self.len = (self.len + 1).min(PLAIN_MAX + 1);
                None
            }
            Ok(DecodeResult::DataComplete) => Some(self.finish()),
            // Ended too soon.
            Err(_) => Some(Err(FrameError::Damaged)),
        }
    }

    fn finish<M: Message>(&mut self) -> Result<Received<M>, FrameError> {
        let plain = self.plain.get(..self.len).ok_or(FrameError::Damaged)?;
        let (plain, crc) = plain
            .split_last_chunk::<CRC_LEN>()
            .ok_or(FrameError::Damaged)?;
        if crc32::checksum(plain) != u32::from_le_bytes(*crc) {
            return Err(FrameError::Damaged);
        }
        let (header, body) = plain
            .split_first_chunk::<HEADER>()
            .ok_or(FrameError::Damaged)?;
        let [version, direction, low, high] = *header;
        if version != VERSION {
            return Err(FrameError::Version(version));
        }
        if direction != M::DIRECTION {
            return Err(FrameError::Direction);
        }
        let sequence = u16::from_le_bytes([low, high]);
        let lost = match (self.next, sequence) {
            (None, _) | (_, 0) => 0,
            (Some(next), _) => sequence.wrapping_sub(next),
        };
        self.next = Some(sequence.wrapping_add(1));
        let message = postcard::from_bytes(body).map_err(|_| FrameError::Schema)?;
        Ok(Received {
            message,
            sequence,
            lost,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::message::Command;
    use proptest::prelude::*;

    fn decode<M: Message>(
        decoder: &mut Decoder,
        bytes: &[u8],
    ) -> Vec<Result<Received<M>, FrameError>> {
        bytes
            .iter()
            .filter_map(|byte| decoder.push(*byte))
            .collect()
    }

    extern crate std;
    use std::{vec, vec::Vec};

    fn regulate(a: f32, b: f32) -> ToBoard {
        ToBoard::Command(Command::Regulate([a, b]))
    }

    proptest! {
        /// Whatever is said arrives, and one damaged bit is always noticed.
        #[test]
        fn round_trip_and_single_bit_errors(a: f32, b: f32, at in 0usize..64, bit in 0u8..8) {
            prop_assume!(!a.is_nan() && !b.is_nan());
            let message = regulate(a, b);
            let mut encoder = Encoder::default();
            let frame = encoder.encode(&message).1.to_vec();
            let (end, body) = frame.split_last().unwrap();
            prop_assert!(frame.len() <= MAX && *end == 0 && !body.contains(&0));
            let got = decode(&mut Decoder::default(), &frame);
            prop_assert_eq!(got, vec![Ok(Received { message, sequence: 0, lost: 0 })]);

            let mut bad = frame.clone();
            let at = at % (frame.len() - 1);
            bad[at] ^= 1 << bit;
            bad.push(0);
            let got = decode::<ToBoard>(&mut Decoder::default(), &bad);
            prop_assert!(got.iter().all(Result::is_err), "{:?}", got);
        }
    }

    #[test]
    fn losses_are_counted_and_the_stream_recovers() {
        let mut encoder = Encoder::default();
        let mut frames: Vec<Vec<u8>> = (0..6)
            .map(|i| encoder.encode(&regulate(i as f32, 0.0)).1.to_vec())
            .collect();
        frames[2].truncate(5); // runs into frame 3
        frames.remove(4);
        let got = decode::<ToBoard>(&mut Decoder::default(), &frames.concat());
        let kinds: Vec<_> = got
            .iter()
            .map(|r| r.map(|r| (r.sequence, r.lost)))
            .collect();
        assert_eq!(
            kinds,
            [Ok((0, 0)), Ok((1, 0)), Err(FrameError::Damaged), Ok((5, 3))]
        );
    }

    #[test]
    fn a_sender_that_begins_anew_has_lost_nothing() {
        let (mut before, mut after) = (Encoder::default(), Encoder::default());
        let mut bytes = Vec::new();
        for encoder in [&mut before, &mut after] {
            for _ in 0..3 {
                bytes.extend_from_slice(encoder.encode(&regulate(0.0, 0.0)).1);
            }
        }
        let got = decode::<ToBoard>(&mut Decoder::default(), &bytes);
        assert!(got.iter().flatten().all(|r| r.lost == 0), "{got:?}");
        assert_eq!(got.len(), 6);
    }

    #[test]
    fn the_other_direction_is_told_apart() {
        let mut encoder = Encoder::default();
        let frame = encoder.encode(&ToBoard::Heartbeat).1.to_vec();
        let got = decode::<ToHost>(&mut Decoder::default(), &frame);
        assert_eq!(got, [Err(FrameError::Direction)]);
    }
}
