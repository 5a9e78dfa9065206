//! Frames: messages on a stream of bytes.
//!
//! ```text
//! COBS( version u8 | direction u8 | sequence u16 | postcard message | CRC-32 ) 0x00
//! ```
//!
//! Integers are little endian. The zero byte occurs nowhere but at the end of a
//! frame, so a receiver that joins late or loses bytes is back in step at the
//! next zero. A frame whose sequence number is not the one after its
//! predecessor's gives the number of lost ones; the number 0, out of turn, means that the sender
//! restarted, and that its frames in between are not known.
//!
//! # Example
//!
//! A receiver loses bytes, and is back in step at the next zero:
//!
//! ```
//! use armbridge_link::frame::{Decoder, Encoder, FrameError, MAX};
//! use armbridge_link::message::{Command, ToBoard};
//!
//! let mut encoder = Encoder::default();
//! let commands = [0.1, 0.2, 0.3].map(|q| ToBoard::Command(Command::Regulate([q, 0.0])));
//! let frames = commands.map(|command| encoder.encode(&command).1.to_vec());
//! assert!(frames.iter().all(|frame| frame.len() <= MAX && frame.ends_with(&[0])));
//!
//! // Garbage, the first frame, the second without its end, the third.
//! let stream = [&[7, 7, 7, 0], &frames[0][..], &frames[1][..5], &[0], &frames[2]].concat();
//! let mut decoder = Decoder::default();
//! let received: Vec<_> = stream.iter().filter_map(|byte| decoder.push::<ToBoard>(*byte)).collect();
//!
//! assert_eq!(received.len(), 4);
//! assert_eq!(received[0], Err(FrameError::Damaged));
//! assert_eq!(received[1].unwrap().message, commands[0]);
//! assert_eq!(received[2], Err(FrameError::Damaged));
//! assert_eq!(received[3].unwrap().message, commands[2]);
//! assert_eq!(received[3].unwrap().lost, 1);
//! ```

mod cobs;
mod output;

use postcard::experimental::max_size::MaxSize;
use serde::de::DeserializeOwned;
use serde::{Serialize, Serializer};

use super::message::{Record, ToBoard, ToHost};
use crate::crc32;
use cobs::{LONGEST, stuff, unstuff};
use output::Output;

/// Version of the frame layout.
const VERSION: u8 = 1;
const HEADER: usize = 4;
const CRC_LEN: usize = 4;

/// Bytes that valid settings, the longest message, are shorter than their types allow: the
/// period has 3 bytes of 5, ten numbers of the limits, below 2^14, have 2 of 3, and another,
/// below 2^7, has 1 of 3. A board has, and so sends, no others.
const SPARED: usize = 2 + 10 + 2;

/// Longest frame of any message, terminator included: COBS adds a byte, and
/// another for every 254.
pub const MAX: usize = {
    let (board, host) = (ToBoard::POSTCARD_MAX_SIZE, ToHost::POSTCARD_MAX_SIZE);
    assert!(
        board + SPARED <= host,
        "the settings are a message to the host"
    );
    let plain = HEADER + CRC_LEN + host - SPARED;
    plain + 1 + plain / 254 + 1
};
const _: () = assert!(MAX <= LONGEST);

/// A message that travels in one direction.
pub trait Message: Serialize + DeserializeOwned + MaxSize {
    /// Distinguishes the directions, so that an end detects its own echo.
    const DIRECTION: u8;
}

impl Message for ToBoard {
    const DIRECTION: u8 = b'B';
}

impl Message for ToHost {
    const DIRECTION: u8 = b'H';
}

/// Encoder of messages to frames.
#[derive(Clone, Debug)]
pub struct Encoder {
    sequence: u16,
    frame: [u8; MAX],
    /// Length of the last frame.
    len: usize,
}

impl Default for Encoder {
    fn default() -> Self {
        Self {
            sequence: 0,
            frame: [0; MAX],
            len: 0,
        }
    }
}

impl Encoder {
    /// The last frame; empty before the first.
    pub fn last(&self) -> &[u8] {
        self.frame.get(..self.len).unwrap_or_default()
    }

    /// The frame for `message` and its sequence number.
    pub fn encode<M: Message>(&mut self, message: &M) -> (u16, &[u8]) {
        self.frame(M::DIRECTION, |into| {
            postcard::to_slice(message, into).map(|body| body.len())
        })
    }

    /// The frame for the [`ToHost::Record`] of this record, without a copy of it.
    pub fn encode_record(&mut self, record: &Record) -> &[u8] {
        let message = RecordMessage(record);
        self.frame(ToHost::DIRECTION, |into| {
            postcard::serialize_with_flavor(&message, Output::new(into))
        })
        .1
    }

    /// The frame of a message of this direction, which `serialize` writes; it returns the length.
    fn frame(
        &mut self,
        direction: u8,
        serialize: impl FnOnce(&mut [u8]) -> postcard::Result<usize>,
    ) -> (u16, &[u8]) {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        // Buffers hold the longest message there is (`MAX`), so that this is
        // never empty; if it were, the receiver would count a lost frame.
        self.len = Self::write(&mut self.frame, direction, sequence, serialize).unwrap_or(0);
        (sequence, self.last())
    }

    /// Writes the frame where it will be sent from: the plain bytes behind the place of
    /// the first COBS code, and then codes in place of zeros.
    fn write(
        frame: &mut [u8; MAX],
        direction: u8,
        sequence: u16,
        serialize: impl FnOnce(&mut [u8]) -> postcard::Result<usize>,
    ) -> Option<usize> {
        let (first_code, plain) = frame.split_first_mut()?;
        let [low, high] = sequence.to_le_bytes();
        let (header, rest) = plain.split_first_chunk_mut::<HEADER>()?;
        *header = [VERSION, direction, low, high];
        let body = serialize(rest).ok()?;
        let (content, rest) = plain.split_at_mut_checked(HEADER + body)?;
        let (crc, rest) = rest.split_first_chunk_mut()?;
        *crc = crc32::checksum(content).to_le_bytes();
        *rest.first_mut()? = 0;
        let plain = plain.get_mut(..HEADER + body + CRC_LEN)?;
        *first_code = stuff(plain);
        // The first code and the terminator.
        Some(plain.len() + 2)
    }
}

/// Place of [`ToHost::Record`] among its variants; a test compares both.
const RECORD_INDEX: u32 = 16;

/// [`ToHost::Record`] of a borrowed record.
struct RecordMessage<'a>(&'a Record);

impl Serialize for RecordMessage<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_newtype_variant("ToHost", RECORD_INDEX, "Record", self.0)
    }
}

/// Reason why a frame is rejected.
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

/// A message, the number of its frame, and the number of frames lost before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received<M> {
    /// The message.
    pub message: M,
    /// Sequence number of the frame.
    pub sequence: u16,
    /// Frames lost since the previous intact one; 0 if the sender began anew.
    pub lost: u16,
}

/// Decoder of frames in a stream, one byte at a time.
#[derive(Debug)]
pub struct Decoder {
    /// The frame so far, as received.
    frame: [u8; MAX],
    /// Its length so far; [`MAX`] if it is too long.
    len: usize,
    next: Option<u16>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            frame: [0; MAX],
            len: 0,
            next: None,
        }
    }
}

impl Decoder {
    /// Takes one byte; `Some` when it ends a frame.
    pub fn push<M: Message>(&mut self, byte: u8) -> Option<Result<Received<M>, FrameError>> {
        if byte != 0 {
            if let Some(slot) = self.frame.get_mut(self.len) {
                *slot = byte;
                self.len += 1;
            }
            return None;
        }
        match core::mem::take(&mut self.len) {
            // Two terminators in a row are no frame, but sent to get into step.
            0 => None,
            len => Some(self.finish(len)),
        }
    }

    fn finish<M: Message>(&mut self, len: usize) -> Result<Received<M>, FrameError> {
        // A frame that fills the buffer has no room for its terminator: too long.
        let frame = self.frame.get_mut(..len).filter(|_| len < MAX);
        let plain = frame.and_then(unstuff).ok_or(FrameError::Damaged)?;
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
    use crate::message::{Command, TickInput};
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
    use std::vec;
    use std::vec::Vec;

    fn regulate(a: f32, b: f32) -> ToBoard {
        ToBoard::Command(Command::Regulate([a, b]))
    }

    proptest! {
        /// Every message arrives, and one damaged bit is always detected.
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
    fn a_frame_that_is_too_long_is_damaged_once() {
        let mut bytes = vec![1; 3 * MAX];
        bytes.push(0);
        let mut decoder = Decoder::default();
        let got = decode::<ToBoard>(&mut decoder, &bytes);
        assert_eq!(got, [Err(FrameError::Damaged)]);
        // The next is understood.
        let mut encoder = Encoder::default();
        let frame = encoder.encode(&ToBoard::Heartbeat).1;
        assert!(matches!(
            decode::<ToBoard>(&mut decoder, frame)[..],
            [Ok(_)]
        ));
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
    fn a_record_is_the_same_with_and_without_a_copy() {
        let record = Record {
            tick: 7,
            input: TickInput {
                start_us: 7_000,
                ..TickInput::AT_REST
            },
            ..Record::NONE
        };
        let (mut copying, mut encoder) = (Encoder::default(), Encoder::default());
        let copied = copying.encode(&ToHost::Record(record)).1;
        assert_eq!(encoder.encode_record(&record), copied);
    }

    #[test]
    fn the_other_direction_is_told_apart() {
        let mut encoder = Encoder::default();
        let frame = encoder.encode(&ToBoard::Heartbeat).1.to_vec();
        let got = decode::<ToHost>(&mut Decoder::default(), &frame);
        assert_eq!(got, [Err(FrameError::Direction)]);
    }
}
