//! Packets of stock servos, and what they mean.

use armbridge_servo::protocol1::frame::{FRAME_MAX, HEADER, checksum};
use armbridge_servo::protocol1::{
    BROADCAST, Frame, Instruction, PacketError, Parser, Status, SyncBlocks,
};

use super::packets::{Found, Packets, feed};

/// Reply of servo 1 to PING (e-Manual).
const ANSWER: [u8; 6] = [HEADER, HEADER, 1, 2, 0, 0xFC];
/// Begins no packet, and completes any that has begun.
const NEUTRAL: u8 = 0;

/// Feeds parsers for packets of up to 8, 16, 64 and all the bytes there can be,
/// and counts what they find.
///
/// # Panics
/// If one of them does what it must not.
pub fn check(input: &[u8]) -> usize {
    // As an intact packet too, so that no checksum has to be hit.
    if let [id, code, parameters @ ..] = input {
        let frame = Frame {
            id: *id,
            code: *code,
            parameters,
        };
        if let Some(bytes) = frame.encode::<FRAME_MAX>() {
            understand::<FRAME_MAX>(&frame, &bytes);
        }
    }
    feed(Parser::<8>::new(), input, NEUTRAL, &ANSWER)
        + feed(Parser::<16>::new(), input, NEUTRAL, &ANSWER)
        + feed(Parser::<64>::new(), input, NEUTRAL, &ANSWER)
        + feed(Parser::<FRAME_MAX>::new(), input, NEUTRAL, &ANSWER)
}

impl<const N: usize> Packets for Parser<N> {
    fn push(&mut self, byte: u8) -> Option<Found> {
        Some(match Parser::push(self, byte)? {
            Ok(frame) => {
                let bytes = frame.encode::<N>().expect("it came out of a parser");
                understand::<N>(&frame, &bytes);
                Found::Intact(bytes.to_vec())
            }
            Err(PacketError::Checksum { .. }) => Found::Damaged,
            Err(PacketError::Header) => Found::Refused,
        })
    }

    fn bytes_held(&self) -> usize {
        Parser::bytes_held(self)
    }

    fn longest(&self) -> usize {
        N
    }

    fn intact(&self, bytes: &[u8]) -> Option<usize> {
        // Of more headers than two the last two count.
        let headers = bytes.iter().take_while(|byte| **byte == HEADER).count();
        let begin = headers.checked_sub(2)?;
        let length = bytes.get(begin + 3).filter(|length| **length >= 2)?;
        let len = usize::from(*length) + 4;
        let (sum, body) = bytes.get(begin + 2..begin + len)?.split_last()?;
        (len <= N && checksum(body) == *sum).then_some(begin + len)
    }
}

/// The meaning of an intact packet encodes to the same bytes.
fn understand<const N: usize>(frame: &Frame, bytes: &[u8]) {
    if let Ok(instruction) = Instruction::decode(frame) {
        let again = instruction.encode::<N>(frame.id).expect("it fitted");
        match instruction {
            // Goes to all, whomever it was addressed to.
            Instruction::SyncWrite { count, blocks, .. } => {
                assert_eq!(again[2], BROADCAST);
                assert_eq!(again[3..again.len() - 1], bytes[3..bytes.len() - 1]);
                let each = usize::from(count) + 1;
                assert_eq!(SyncBlocks::new(count, blocks).count() * each, blocks.len());
            }
            _ => assert_eq!(again, bytes),
        }
    }
    match Status::decode(frame) {
        Some(status) => assert_eq!(status.encode::<N>().expect("it fitted"), bytes),
        None => assert!(frame.id >= BROADCAST || frame.code >= 0x80, "{frame:?}"),
    }
}
