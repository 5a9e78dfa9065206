//! Host side of the control link's protocol: hello, heartbeats, one command repeated until
//! it is acknowledged, and the board's messages in order.
//!
//! A hello is repeated every 25 ms until the board answers it, and again after a reset of
//! the board. A command is repeated at the same interval, with a new sequence number each
//! time; the acknowledgement of the last one is valid. `Busy` is ignored, and so is
//! `EncoderUnknown` until [`ENCODER_REPEATS`] have not helped.

use armbridge_link::frame::{Decoder, Encoder, FrameError, Received};
use armbridge_link::message::{Command, Hello, Refusal, ToBoard, ToHost};
use armbridge_link::schema;
use serde::Serialize;

/// Counts of a link's frames, most of which are records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LinkStats {
    /// Records that the board sent.
    pub sent: u64,
    /// Records that were lost.
    pub lost: u64,
    /// Damaged frames.
    pub damaged: u64,
    /// Records that the board dropped before sending.
    pub dropped: u64,
}

/// Interval of heartbeats, and of repeating an unanswered message: a quarter of
/// the silence after which the board brakes the arm and holds it.
const HEARTBEAT_US: u64 = 25_000;

/// Repetitions of a command to arm while the board learns the noise of the encoders, within 10 s:
/// three blocks of 16 ticks take 4.8 s at the longest period, 100 ms, and as many may be
/// discarded.
const ENCODER_REPEATS: u32 = 400;

/// Message of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "lives for one frame")]
pub enum BoardMessage {
    /// Its hello, with the schema of this program.
    Hello(Hello),
    /// Its hello, with another schema: no other message can be decoded.
    OtherSchema(Hello),
    /// The latest command is executed.
    Done,
    /// The latest command is refused.
    Refused(Refusal),
    /// Any other message.
    Other(ToHost),
}

/// The host's end of the link.
#[derive(Debug, Default)]
pub struct CommandLink {
    encoder: Encoder,
    decoder: Decoder,
    outgoing: Vec<u8>,
    is_greeted: bool,
    /// Latest command, until it is acknowledged, and its last frame's number.
    pending: Option<(Command, Option<u16>)>,
    /// Number of refusals because the board does not know the encoders yet.
    encoder_refusals: u32,
    /// Messages to send once.
    one_shots: Vec<ToBoard>,
    next_us: u64,
    stats: LinkStats,
}

impl CommandLink {
    /// Repeats this command until it is acknowledged; replaces an earlier one.
    pub fn command(&mut self, command: Command) {
        self.pending = Some((command, None));
        self.encoder_refusals = 0;
        self.next_us = 0;
    }

    /// Sends a message once, before all others, without waiting for an acknowledgement.
    pub fn send(&mut self, message: ToBoard) {
        self.one_shots.push(message);
        self.next_us = 0;
    }

    /// Resets the link after the connection broke: discards the command, and begins the
    /// next connection with a hello.
    pub fn disconnected(&mut self) {
        self.decoder = Decoder::default();
        self.is_greeted = false;
        self.pending = None;
        self.one_shots.clear();
        self.next_us = 0;
    }

    /// Encodes a goodbye, on which the board disarms; no message follows it.
    pub fn goodbye(&mut self) -> &[u8] {
        self.disconnected();
        self.next_us = u64::MAX;
        self.outgoing.clear();
        // An empty frame ends a partial frame in the board's receiver, which would lose this one.
        self.outgoing.push(0);
        let (_, frame) = self.encoder.encode(&ToBoard::Goodbye);
        self.outgoing.extend_from_slice(frame);
        &self.outgoing
    }

    /// Whether the board has answered the hello.
    pub fn is_greeted(&self) -> bool {
        self.is_greeted
    }

    /// Whether every command has been acknowledged.
    pub fn is_settled(&self) -> bool {
        self.pending.is_none()
    }

    /// Counts of the frames so far; most of them are records.
    pub fn stats(&self) -> LinkStats {
        self.stats
    }

    /// Bytes for the board, if a message is due.
    pub fn transmit(&mut self, now_us: u64) -> &[u8] {
        self.outgoing.clear();
        if now_us < self.next_us {
            return &self.outgoing;
        }
        self.next_us = now_us + HEARTBEAT_US;
        for one_shot in self.one_shots.drain(..) {
            self.outgoing
                .extend_from_slice(self.encoder.encode(&one_shot).1);
        }
        let message = match (self.is_greeted, &self.pending) {
            (false, _) => {
                // An empty frame ends a partial frame in the board's receiver.
                self.outgoing.push(0);
                ToBoard::Hello(schema::HELLO)
            }
            (true, Some((command, _))) => ToBoard::Command(*command),
            (true, None) => ToBoard::Heartbeat,
        };
        let (sequence, frame) = self.encoder.encode(&message);
        self.outgoing.extend_from_slice(frame);
        if let (true, Some((_, sent_as))) = (self.is_greeted, &mut self.pending) {
            *sent_as = Some(sequence);
        }
        &self.outgoing
    }

    /// Latest time of the next call of [`CommandLink::transmit`].
    pub fn wake_at_us(&self) -> u64 {
        self.next_us
    }

    /// Decodes bytes from the board, up to the end of a message; the rest stays in `bytes`.
    /// `None` at their end.
    pub fn receive(&mut self, bytes: &mut &[u8]) -> Option<BoardMessage> {
        while let Some((byte, rest)) = bytes.split_first() {
            *bytes = rest;
            match self.decoder.push::<ToHost>(*byte) {
                None => {}
                Some(Ok(received)) => {
                    if let Some(message) = self.take(&received) {
                        return Some(message);
                    }
                }
                // Intact but not decodable: before the hellos are exchanged that
                // is another build, as the hello shows, whose layout is fixed.
                Some(Err(
                    FrameError::Damaged
                    | FrameError::Version(_)
                    | FrameError::Direction
                    | FrameError::Schema,
                )) => self.stats.damaged += 1,
            }
        }
        None
    }

    fn take(&mut self, received: &Received<ToHost>) -> Option<BoardMessage> {
        let lost = u64::from(received.lost);
        self.stats.lost += lost;
        self.stats.sent += lost + 1;
        match received.message {
            ToHost::Hello(hello) if hello.schema == schema::HASH && self.is_greeted => {
                // The board has lost the session, after a reset or another host's hello, or
                // answers a repeated hello. The next hello makes it drop what was sent
                // before: that is repeated, and its refusal as stale does not count.
                self.is_greeted = false;
                if let Some((_, sent_as)) = &mut self.pending {
                    *sent_as = None;
                }
                self.next_us = 0;
                None
            }
            ToHost::Hello(hello) if hello.schema == schema::HASH => {
                self.is_greeted = true;
                self.next_us = 0;
                Some(BoardMessage::Hello(hello))
            }
            ToHost::Hello(hello) => Some(BoardMessage::OtherSchema(hello)),
            // It is repeated with the next heartbeat.
            ToHost::Ack {
                result: Err(Refusal::Busy),
                ..
            } => None,
            ToHost::Ack {
                result: Err(Refusal::EncoderUnknown { .. }),
                ..
            } if self.encoder_refusals < ENCODER_REPEATS => {
                self.encoder_refusals += 1;
                None
            }
            ToHost::Ack {
                sequence, result, ..
            } => {
                let is_ours = matches!(self.pending, Some((_, Some(sent))) if sent == sequence);
                is_ours.then(|| {
                    self.pending = None;
                    result.map_or_else(BoardMessage::Refused, |()| BoardMessage::Done)
                })
            }
            ToHost::Record(record) => {
                self.stats.dropped = u64::from(record.dropped);
                Some(BoardMessage::Other(received.message))
            }
            ToHost::Departs { .. }
            | ToHost::Began(_)
            | ToHost::Settings(_)
            | ToHost::Absent { .. }
            | ToHost::Found { .. }
            | ToHost::Mixed(_)
            | ToHost::Unprepared { .. }
            | ToHost::Passthrough
            | ToHost::Port(_)
            | ToHost::Board(_)
            | ToHost::Tripped(_)
            | ToHost::Off(_)
            | ToHost::Concluded(_)
            | ToHost::Temperature { .. } => Some(BoardMessage::Other(received.message)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receive(
        link: &mut CommandLink,
        board: &mut Encoder,
        message: &ToHost,
    ) -> Option<BoardMessage> {
        let frame = board.encode(message).1.to_vec();
        link.receive(&mut frame.as_slice())
    }

    /// A board answers both of two hellos; the command between the answers is dropped with
    /// the session that the first one began.
    #[test]
    fn a_command_that_a_second_hello_drops_is_repeated() {
        let (mut link, mut board) = (CommandLink::default(), Encoder::default());
        let hello = ToHost::Hello(schema::HELLO);
        let ack = |sequence, result| ToHost::Ack {
            sequence,
            result,
            moment: None,
        };
        link.command(Command::Idle);
        link.transmit(0);
        assert!(receive(&mut link, &mut board, &hello).is_some());
        link.transmit(1);
        let (_, dropped) = link.pending.unwrap();
        assert_eq!(receive(&mut link, &mut board, &hello), None);
        let stale = ack(dropped.unwrap(), Err(Refusal::Stale));
        assert_eq!(receive(&mut link, &mut board, &stale), None);
        assert!(!link.is_greeted() && !link.is_settled());
        link.transmit(2);
        assert!(receive(&mut link, &mut board, &hello).is_some());
        link.transmit(3);
        let (_, repeated) = link.pending.unwrap();
        let done = ack(repeated.unwrap(), Ok(()));
        assert_eq!(
            receive(&mut link, &mut board, &done),
            Some(BoardMessage::Done)
        );
    }
}
