//! What was said on a link, in order: the truth that everything else is made of.
//!
//! An [`Ear`] is given the raw bytes of both directions with the time at which
//! the host read or wrote them, and tells [`Event`]s. Recorder, dashboard and
//! server all listen through one; none of them asks the link for anything else.

use armbridge_shared::link::frame::{Decoder, FrameError, Message, Received};
use armbridge_shared::link::message::{Record, ToBoard, ToHost};

/// Which way bytes travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From host to board.
    ToBoard,
    /// From board to host.
    ToHost,
}

/// Something that happened on the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When the host read or wrote the frame's last byte: ns since 1970, or of
    /// virtual time.
    pub host_ns: u64,
    /// What.
    pub what: What,
}

/// What can happen on a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// The host said this, in the frame with this sequence number.
    Asked(u16, ToBoard),
    /// The board said this, in the frame with this sequence number.
    Told(u16, ToHost),
    /// So many frames went missing before the one that follows.
    Lost(Direction, u16),
    /// A frame could not be read.
    Garbled(Direction, FrameError),
    /// The connection broke; what is said after it is said on another.
    Parted,
}

impl Event {
    /// The tick that it tells of, if it is one.
    pub fn record(&self) -> Option<Record> {
        match self.what {
            What::Told(_, ToHost::Record(record)) => Some(record),
            What::Told(..)
            | What::Asked(..)
            | What::Lost(..)
            | What::Garbled(..)
            | What::Parted => None,
        }
    }
}

/// Reads both directions of a link.
#[derive(Debug, Default)]
pub struct Ear {
    to_board: Decoder,
    to_host: Decoder,
}

impl Ear {
    /// Takes bytes that travelled at this time; calls `hear` with what they say.
    pub fn take(
        &mut self,
        direction: Direction,
        host_ns: u64,
        bytes: &[u8],
        mut hear: impl FnMut(Event),
    ) {
        let mut tell = |what| hear(Event { host_ns, what });
        for byte in bytes {
            match direction {
                Direction::ToBoard => {
                    read(&mut self.to_board, *byte, direction, What::Asked, &mut tell);
                }
                Direction::ToHost => {
                    read(&mut self.to_host, *byte, direction, What::Told, &mut tell);
                }
            }
        }
    }
}

fn read<M: Message>(
    decoder: &mut Decoder,
    byte: u8,
    direction: Direction,
    what: impl Fn(u16, M) -> What,
    tell: &mut impl FnMut(What),
) {
    match decoder.push::<M>(byte) {
        None => {}
        Some(Ok(Received {
            message,
            sequence,
            lost,
        })) => {
            if lost > 0 {
                tell(What::Lost(direction, lost));
            }
            tell(what(sequence, message));
        }
        Some(Err(error)) => tell(What::Garbled(direction, error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_shared::link::frame::Encoder;

    #[test]
    fn both_directions_are_told_apart_and_gaps_are_counted() {
        let (mut host, mut board) = (Encoder::default(), Encoder::default());
        let mut to_host = board.encode(&ToHost::Passthrough).1.to_vec();
        let _ = board.encode(&ToHost::Passthrough);
        to_host.extend_from_slice(board.encode(&ToHost::Passthrough).1);
        to_host.extend_from_slice(&[7, 0]);
        let to_board = host.encode(&ToBoard::Heartbeat).1.to_vec();
        let (mut ear, mut heard) = (Ear::default(), Vec::new());
        ear.take(Direction::ToHost, 1, &to_host, |event| heard.push(event));
        ear.take(Direction::ToBoard, 2, &to_board, |event| heard.push(event));
        let heard: Vec<_> = heard
            .iter()
            .map(|event| (event.host_ns, event.what))
            .collect();
        assert_eq!(
            heard,
            [
                (1, What::Told(0, ToHost::Passthrough)),
                (1, What::Lost(Direction::ToHost, 1)),
                (1, What::Told(2, ToHost::Passthrough)),
                (1, What::Garbled(Direction::ToHost, FrameError::Damaged)),
                (2, What::Asked(0, ToBoard::Heartbeat)),
            ]
        );
    }
}
