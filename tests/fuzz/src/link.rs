//! Frames of the link between host and board, and the messages in them.

use std::fmt::Debug;

use armbridge_link::frame::{Decoder, Encoder, FrameError, MAX, Message};
use armbridge_link::message::{Command, Missing, ToBoard, ToHost};

use super::frames;

/// Layout of the frames that are written here.
const VERSION: u8 = 1;
/// Number of the frame that an input is put into.
const SEQUENCE: u16 = 0x1234;

/// Feeds both ends of the link, and counts the messages they understand.
///
/// # Panics
/// If one of them does what it must not.
pub fn check(input: &[u8]) -> usize {
    to_board(input) + to_host(input)
}

/// Feeds the board's end, and counts the messages it understands.
///
/// # Panics
/// If it does what it must not.
pub fn to_board(input: &[u8]) -> usize {
    let regulate = ToBoard::Command(Command::Regulate([0.25, -0.5]));
    stream(input, &regulate) + body::<ToBoard>(input)
}

/// Feeds the host's end, and counts the messages it understands.
///
/// # Panics
/// If it does what it must not.
pub fn to_host(input: &[u8]) -> usize {
    let absent = ToHost::Absent {
        joint: 1,
        missing: Missing::EchoOnly,
    };
    stream(input, &absent) + body::<ToHost>(input)
}

/// Any bytes, then a zero: the next message arrives.
fn stream<M: Message + Debug + PartialEq>(input: &[u8], message: &M) -> usize {
    let mut decoder = Decoder::default();
    let mut understood = 0;
    for byte in input.iter().chain(&[0]) {
        let result = decoder.push::<M>(*byte);
        assert!(result.is_none() || *byte == 0, "{result:?} in mid frame");
        if let Some(Ok(received)) = result {
            can_be_said_again(&received.message);
            understood += 1;
        }
    }
    let mut encoder = Encoder::default();
    let (sequence, frame) = encoder.encode(message);
    let received = push(&mut decoder, frame).expect("in step after a zero");
    assert_eq!((received.0, &received.1), (sequence, message));
    understood
}

/// Any bytes in an intact frame: a message, or none of this build.
fn body<M: Message + Debug>(input: &[u8]) -> usize {
    let frame = frames::frame(VERSION, M::DIRECTION, SEQUENCE, input);
    match push::<M>(&mut Decoder::default(), &frame) {
        Ok((sequence, message)) => {
            assert_eq!(sequence, SEQUENCE);
            can_be_said_again(&message);
            return 1;
        }
        Err(FrameError::Damaged) => assert!(frame.len() > MAX, "{frame:02x?}"),
        Err(error) => assert_eq!(error, FrameError::Schema, "{frame:02x?}"),
    }
    0
}

/// Pushes a frame, whose last byte selects its contents.
fn push<M: Message + Debug>(decoder: &mut Decoder, frame: &[u8]) -> Result<(u16, M), FrameError> {
    let (end, before) = frame.split_last().expect("a frame has bytes");
    for byte in before {
        assert!(decoder.push::<M>(*byte).is_none(), "{frame:02x?}");
    }
    let result = decoder.push(*end).expect("the end of a frame");
    result.map(|received| (received.sequence, received.message))
}

/// A decoded message encodes to the same bytes. Compared as bytes, since no NaN equals
/// itself.
fn can_be_said_again<M: Message + Debug>(message: &M) {
    let (mut first, mut second) = (Encoder::default(), Encoder::default());
    let (_, bytes) = first.encode(message);
    let (_, again) = push::<M>(&mut Decoder::default(), bytes).expect("an intact frame");
    assert_eq!(second.encode(&again).1, bytes, "{message:?}");
}
