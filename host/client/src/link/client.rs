//! A host that speaks to a board: hello, heartbeats, commands until they are
//! acknowledged, and everything the board says, in order.
//!
//! Sans-io and clockless, like the board's end: the same client runs in the
//! bench's virtual time and over a socket in wall-clock time.

use armbridge_shared::link::frame::{Decoder, Encoder, FrameError, Received};
use armbridge_shared::link::message::{Command, Hello, Refusal, ToBoard, ToHost};
use armbridge_shared::link::schema;

use serde::Serialize;

/// What became of the records on their way to the host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LinkStats {
    /// Records that the board sent.
    pub sent: u64,
    /// Records that never arrived.
    pub lost: u64,
    /// Frames that arrived damaged.
    pub damaged: u64,
    /// Records that the board dropped before sending.
    pub dropped: u64,
}

/// Interval of heartbeats, and of repeating what was not answered: a quarter of
/// the silence after which the board brakes the arm and holds it.
const HEARTBEAT_US: u64 = 25_000;

/// What the board said.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "lives for one frame")]
pub enum Said {
    /// Its hello, with a schema equal to ours.
    Hello,
    /// Its hello, with another schema: nothing else can be understood.
    OtherSchema(Hello),
    /// It did what was commanded last.
    Done,
    /// It refused what was commanded last.
    Refused(Refusal),
    /// Anything else.
    Told(ToHost),
}

/// The host's end of the link.
#[derive(Debug, Default)]
pub struct Client {
    encoder: Encoder,
    decoder: Decoder,
    outgoing: Vec<u8>,
    is_greeted: bool,
    /// Latest command, until it is acknowledged, and its last frame's number.
    pending: Option<(Command, Option<u16>)>,
    /// To be said once.
    asides: Vec<ToBoard>,
    next_us: u64,
    stats: LinkStats,
}

impl Client {
    /// Wants `command` done; replaces one that is not acknowledged yet.
    pub fn command(&mut self, command: Command) {
        self.pending = Some((command, None));
        self.next_us = 0;
    }

    /// Says this once, before anything else, without waiting for an answer.
    pub fn say(&mut self, message: ToBoard) {
        self.asides.push(message);
        self.next_us = 0;
    }

    /// The connection broke: what was on its way is forgotten, and the next one begins
    /// with a hello.
    pub fn parted(&mut self) {
        self.decoder = Decoder::default();
        self.is_greeted = false;
        self.pending = None;
        self.asides.clear();
        self.next_us = 0;
    }

    /// The last words: the board disarms, and nothing is said any more.
    pub fn farewell(&mut self) -> &[u8] {
        self.parted();
        self.next_us = u64::MAX;
        self.outgoing.clear();
        let (_, frame) = self.encoder.encode(&ToBoard::Goodbye);
        self.outgoing.extend_from_slice(frame);
        &self.outgoing
    }

    /// Whether the board has answered the hello.
    pub fn is_greeted(&self) -> bool {
        self.is_greeted
    }

    /// Whether everything commanded has been acknowledged.
    pub fn is_settled(&self) -> bool {
        self.pending.is_none()
    }

    /// What became of the frames so far; most of them are records.
    pub fn stats(&self) -> LinkStats {
        self.stats
    }

    /// Bytes for the board, if it is time to say something.
    pub fn transmit(&mut self, now_us: u64) -> &[u8] {
        self.outgoing.clear();
        if now_us < self.next_us {
            return &self.outgoing;
        }
        self.next_us = now_us + HEARTBEAT_US;
        for aside in self.asides.drain(..) {
            self.outgoing
                .extend_from_slice(self.encoder.encode(&aside).1);
        }
        let message = match (self.is_greeted, &self.pending) {
            (false, _) => {
                // An empty frame ends whatever half frame the board is in.
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

    /// When to call [`Client::transmit`] again.
    pub fn wake_at_us(&self) -> u64 {
        self.next_us
    }

    /// Takes bytes from the board; calls `heard` with what they say.
    pub fn receive(&mut self, bytes: &[u8], mut heard: impl FnMut(Said)) {
        for byte in bytes {
            match self.decoder.push::<ToHost>(*byte) {
                None => {}
                Some(Ok(received)) => {
                    if let Some(said) = self.take(received) {
                        heard(said);
                    }
                }
                // Intact but unreadable: before the hellos are exchanged that
                // is another build; the hello, whose layout is fixed, tells.
                Some(Err(
                    FrameError::Damaged
                    | FrameError::Version(_)
                    | FrameError::Direction
                    | FrameError::Schema,
                )) => self.stats.damaged += 1,
            }
        }
    }

    fn take(&mut self, received: Received<ToHost>) -> Option<Said> {
        let lost = u64::from(received.lost);
        self.stats.lost += lost;
        self.stats.sent += lost + 1;
        match received.message {
            ToHost::Hello(hello) if hello.schema == schema::HASH && self.is_greeted => {
                // It has forgotten us, after a reset or somebody else's hello.
                self.is_greeted = false;
                self.next_us = 0;
                None
            }
            ToHost::Hello(hello) if hello.schema == schema::HASH => {
                self.is_greeted = true;
                self.next_us = 0;
                Some(Said::Hello)
            }
            ToHost::Hello(hello) => Some(Said::OtherSchema(hello)),
            // It is said again with the next heartbeat.
            ToHost::Ack {
                result: Err(Refusal::Busy),
                ..
            } => None,
            ToHost::Ack {
                sequence, result, ..
            } => {
                let is_ours = matches!(self.pending, Some((_, Some(sent))) if sent == sequence);
                is_ours.then(|| {
                    self.pending = None;
                    result.map_or_else(Said::Refused, |()| Said::Done)
                })
            }
            ToHost::Record(record) => {
                self.stats.dropped = u64::from(record.dropped);
                Some(Said::Told(received.message))
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
            | ToHost::Temperature { .. } => Some(Said::Told(received.message)),
        }
    }
}
