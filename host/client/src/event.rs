//! Events of a link: the messages of both directions, in order.
//!
//! A [`LinkDecoder`] takes the raw bytes of both directions with the time at which
//! the host read or wrote them, and emits [`Event`]s. Recorder, dashboard and server
//! each have one, which is their only access to the link.

use armbridge_link::frame::{Decoder, FrameError, Message, Received};
use armbridge_link::message::{Record, ToBoard, ToHost};

/// Direction of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From host to board.
    ToBoard,
    /// From board to host.
    ToHost,
}

/// Event on the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Time at which the host read or wrote the frame's last byte: ns since 1970, or of
    /// virtual time.
    pub host_ns: u64,
    /// Content.
    pub kind: EventKind,
}

/// Content of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// Message of the host, in the frame with this sequence number.
    Sent(u16, ToBoard),
    /// Message of the board, in the frame with this sequence number.
    Received(u16, ToHost),
    /// Number of frames that are missing before the next one.
    Lost(Direction, u16),
    /// An invalid frame.
    Damaged(Direction, FrameError),
    /// The connection broke; later messages belong to another one.
    Disconnected,
}

impl Event {
    /// The record of a tick, if it is one.
    pub fn record(&self) -> Option<Record> {
        match self.kind {
            EventKind::Received(_, ToHost::Record(record)) => Some(record),
            EventKind::Received(..)
            | EventKind::Sent(..)
            | EventKind::Lost(..)
            | EventKind::Damaged(..)
            | EventKind::Disconnected => None,
        }
    }
}

/// Decodes both directions of a link.
#[derive(Debug, Default)]
pub struct LinkDecoder {
    to_board: Decoder,
    to_host: Decoder,
}

impl LinkDecoder {
    /// Decodes bytes that travelled at this time; passes their events to `on_event`.
    pub fn take(
        &mut self,
        direction: Direction,
        host_ns: u64,
        bytes: &[u8],
        mut on_event: impl FnMut(Event),
    ) {
        let mut emit = |kind| on_event(Event { host_ns, kind });
        for byte in bytes {
            match direction {
                Direction::ToBoard => {
                    decode(
                        &mut self.to_board,
                        *byte,
                        direction,
                        EventKind::Sent,
                        &mut emit,
                    );
                }
                Direction::ToHost => {
                    decode(
                        &mut self.to_host,
                        *byte,
                        direction,
                        EventKind::Received,
                        &mut emit,
                    );
                }
            }
        }
    }
}

fn decode<M: Message>(
    decoder: &mut Decoder,
    byte: u8,
    direction: Direction,
    kind: impl Fn(u16, M) -> EventKind,
    emit: &mut impl FnMut(EventKind),
) {
    match decoder.push::<M>(byte) {
        None => {}
        Some(Ok(Received {
            message,
            sequence,
            lost,
        })) => {
            if lost > 0 {
                emit(EventKind::Lost(direction, lost));
            }
            emit(kind(sequence, message));
        }
        Some(Err(error)) => emit(EventKind::Damaged(direction, error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::frame::Encoder;

    #[test]
    fn both_directions_are_decoded_and_gaps_are_counted() {
        let (mut host, mut board) = (Encoder::default(), Encoder::default());
        let mut to_host = board.encode(&ToHost::Passthrough).1.to_vec();
        let _ = board.encode(&ToHost::Passthrough);
        to_host.extend_from_slice(board.encode(&ToHost::Passthrough).1);
        to_host.extend_from_slice(&[7, 0]);
        let to_board = host.encode(&ToBoard::Heartbeat).1.to_vec();
        let (mut decoder, mut events) = (LinkDecoder::default(), Vec::new());
        decoder.take(Direction::ToHost, 1, &to_host, |event| events.push(event));
        decoder.take(Direction::ToBoard, 2, &to_board, |event| events.push(event));
        let events: Vec<_> = events
            .iter()
            .map(|event| (event.host_ns, event.kind))
            .collect();
        assert_eq!(
            events,
            [
                (1, EventKind::Received(0, ToHost::Passthrough)),
                (1, EventKind::Lost(Direction::ToHost, 1)),
                (1, EventKind::Received(2, ToHost::Passthrough)),
                (
                    1,
                    EventKind::Damaged(Direction::ToHost, FrameError::Damaged)
                ),
                (2, EventKind::Sent(0, ToBoard::Heartbeat)),
            ]
        );
    }
}
