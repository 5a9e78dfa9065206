//! Packets of X-series servos, and what they mean.

use armbridge_servo::protocol2::crc::checksum;
use armbridge_servo::protocol2::frame::{HEADER, OVERHEAD, STATUS};
use armbridge_servo::protocol2::{
    BROADCAST, FastStatus, Frame, Instruction, PacketError, Parser, Part, Status,
};

use super::packets::{Found, Packets, feed};

/// Reply of servo 1 to PING (e-Manual).
const ANSWER: [u8; 14] = [
    0xFF, 0xFF, 0xFD, 0, 1, 7, 0, STATUS, 0, 0x06, 0x04, 0x26, 0x65, 0x5D,
];
/// Begins no packet, and completes any that has begun.
const NEUTRAL: u8 = 0;
/// Bytes of the longest packet here.
const LONGEST: usize = 300;

/// Feeds parsers for packets of up to 16, 64 and 300 bytes, and counts what they find.
///
/// # Panics
/// If one of them does what it must not.
pub fn check(input: &[u8]) -> usize {
    // As an intact packet too, so that no CRC has to be hit.
    if let [id, code, parameters @ ..] = input {
        let frame = Frame {
            id: *id,
            code: *code,
            parameters,
        };
        if let Some(bytes) = encode::<LONGEST>(&frame) {
            understand::<LONGEST>(&frame, &bytes);
            let mut parser = Parser::<LONGEST>::new();
            let found = bytes.iter().filter(|byte| parser.push(**byte).is_some());
            assert_eq!(found.count(), 1, "{bytes:02x?}");
        }
    }
    fast(input);
    feed(Parser::<16>::new(), input, NEUTRAL, &ANSWER)
        + feed(Parser::<64>::new(), input, NEUTRAL, &ANSWER)
        + feed(Parser::<LONGEST>::new(), input, NEUTRAL, &ANSWER)
}

/// The bytes of a frame; those of a fast status packet have no stuffing.
fn encode<const N: usize>(frame: &Frame) -> Option<Vec<u8>> {
    if (frame.id, frame.code) != (BROADCAST, STATUS) {
        return frame.encode::<N>().map(|bytes| bytes.to_vec());
    }
    let [low, high] = u16::try_from(frame.parameters.len() + 3)
        .ok()?
        .to_le_bytes();
    let head = [frame.id, low, high, frame.code];
    let mut bytes = [&HEADER[..], &head, frame.parameters].concat();
    bytes.extend(checksum(&bytes).to_le_bytes());
    (bytes.len() <= N).then_some(bytes)
}

impl<const N: usize> Packets for Parser<N> {
    fn push(&mut self, byte: u8) -> Option<Found> {
        Some(match Parser::push(self, byte)? {
            Ok(frame) => {
                let bytes = encode::<N>(&frame).expect("it came out of a parser");
                understand::<N>(&frame, &bytes);
                Found::Intact(bytes)
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
        // Of more FF than two the last two count.
        let headers = bytes.iter().take_while(|byte| **byte == HEADER[0]).count();
        let begin = headers.checked_sub(2)?;
        let packet = bytes.get(begin..)?;
        let &[a, b, c, d, id, low, high, code, ..] = packet else {
            return None;
        };
        let len = usize::from(u16::from_le_bytes([low, high])) + OVERHEAD - 3;
        let packet = packet.get(..len)?;
        let (body, crc) = packet.split_at_checked(len.checked_sub(2)?)?;
        let stuffed = body.get(OVERHEAD - 3..)?;
        let marks = stuffed.windows(3).enumerate();
        let marks = marks.filter(|(_, three)| *three == &HEADER[..3]);
        let are_stuffed = marks
            .into_iter()
            .all(|(at, _)| stuffed.get(at + 3) == Some(&HEADER[2]));
        let is_whole = [a, b, c, d] == HEADER
            && len >= OVERHEAD
            && len <= N
            && *crc == checksum(body).to_le_bytes()
            && (are_stuffed || (id, code) == (BROADCAST, STATUS));
        is_whole.then_some(begin + len)
    }
}

/// The meaning of an intact packet encodes to the same bytes.
fn understand<const N: usize>(frame: &Frame, bytes: &[u8]) {
    if let Ok(instruction) = Instruction::decode(frame) {
        let again = instruction.encode::<N>(frame.id).expect("it fitted");
        let to_all = matches!(
            instruction,
            Instruction::SyncRead { .. }
                | Instruction::FastSyncRead { .. }
                | Instruction::SyncWrite { .. }
                | Instruction::BulkRead(_)
                | Instruction::FastBulkRead(_)
                | Instruction::BulkWrite(_)
        );
        if to_all {
            // Whatever it was addressed to.
            assert_eq!(again[4], BROADCAST);
            assert_eq!(again[5..again.len() - 2], bytes[5..bytes.len() - 2]);
        } else {
            assert_eq!(again, bytes);
        }
    }
    if let Some(status) = Status::decode(frame) {
        assert_eq!(status.encode::<N>().expect("it fitted"), bytes);
    }
}

/// Parts of a fast status packet are found again, and each of its beginnings has only whole ones.
fn fast(input: &[u8]) {
    let Some((first, data)) = input.split_first() else {
        return;
    };
    let count = usize::from(*first % 12) + 1;
    let blocks = data.chunks_exact(count).take(8);
    let parts: Vec<Part<'_>> = blocks
        .enumerate()
        .map(|(id, data)| Part {
            id: id as u8,
            is_alert: data[0] & 1 != 0,
            error: None,
            data,
        })
        .collect();
    let packet = FastStatus::encode::<LONGEST>(&parts, count).expect("room");
    let found = FastStatus::new(&packet, count).expect("its head");
    assert!(found.eq(parts.iter().copied().map(Ok)));
    for end in 0..packet.len() {
        let whole = (0..=parts.len())
            .rev()
            .find(|n| FastStatus::packet_bytes(*n, count) <= end);
        let found = FastStatus::new(&packet[..end], count).map_or(0, Iterator::count);
        assert_eq!(found, whole.unwrap_or(0));
    }
}
