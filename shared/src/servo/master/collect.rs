//! What came back while the master listened.

use super::super::morpheus::{self, MASTER, Reply, ServoId};
use super::super::protocol1::{self, Alarms, Status};
use super::super::{Firmware, Missing, Sample};
use super::transaction::Asked;
use crate::JOINTS;
use heapless::Vec;

/// Length of a Morpheus answer to a ping, and of a position.
const PING_LEN: usize = 6;
const POSITION_LEN: usize = 7;
/// Bytes of the longest reply that is taken apart: a whole register map.
const REPLY_MAX: usize = 66;

/// Which replies are awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Awaited {
    /// A Morpheus ping's answer from the servo of this joint.
    Ping(usize),
    /// A Morpheus ping's answer from every servo.
    Pings,
    /// A position from every Morpheus servo.
    Positions,
    /// A stock servo's status packet: a position if there are two parameters.
    Status {
        joint: usize,
        id: u8,
        parameters: u8,
    },
    /// Whatever was asked for by [`super::Transaction::Ask`].
    Reply(Asked),
}

/// What else was heard, weakest evidence first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Evidence {
    Nothing,
    /// Bytes.
    Bytes,
    /// An intact packet that nobody asked for.
    Stranger,
    /// A packet with a wrong checksum.
    Damaged,
    /// The receiver reported framing, noise or overrun.
    LineError,
}

/// Finds packets of the bus's protocol.
#[derive(Debug)]
enum Listener {
    /// Short Morpheus replies: falls for few stray headers.
    Chain(morpheus::Parser),
    Morpheus(morpheus::frame::Parser<REPLY_MAX>),
    Stock(protocol1::Parser<REPLY_MAX>),
}

/// A reply's payload, with the error byte of a stock servo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Payload {
    /// What a stock servo complains of.
    pub alarms: Alarms,
    /// Parameters or data.
    pub data: Vec<u8, REPLY_MAX>,
}

/// Replies sorted by joint, and evidence about those that did not come.
#[derive(Debug)]
pub(super) struct Collect {
    awaited: Awaited,
    listener: Listener,
    /// Position, or 0 for a ping's answer.
    answers: [Option<u16>; JOINTS],
    alarms: Alarms,
    reply: Option<Payload>,
    /// The strongest so far.
    evidence: Evidence,
}

impl Collect {
    pub(super) fn new(awaited: Awaited, firmware: Firmware) -> Self {
        let listener = match (awaited, firmware) {
            (Awaited::Ping(_) | Awaited::Pings | Awaited::Positions, _) => {
                Listener::Chain(morpheus::Parser::to(MASTER))
            }
            (Awaited::Reply(_), Firmware::Morpheus) => {
                Listener::Morpheus(morpheus::frame::Parser::any())
            }
            (Awaited::Status { .. } | Awaited::Reply(_), _) => {
                Listener::Stock(protocol1::Parser::new())
            }
        };
        Self {
            awaited,
            listener,
            answers: [None; JOINTS],
            alarms: Alarms::NONE,
            reply: None,
            evidence: Evidence::Nothing,
        }
    }

    /// A byte that is not our echo.
    pub(super) fn byte(&mut self, byte: u8, ids: [ServoId; JOINTS]) {
        self.note(Evidence::Bytes);
        let awaited = self.awaited;
        match &mut self.listener {
            Listener::Chain(parser) => match parser.push(byte) {
                None | Some(Err(morpheus::Damage::Header)) => {}
                Some(Err(morpheus::Damage::Checksum { .. })) => self.note(Evidence::Damaged),
                Some(Ok(frame)) => {
                    let reply = Reply::of(&frame);
                    self.chain(reply, ids);
                }
            },
            Listener::Morpheus(parser) => match parser.push(byte) {
                None | Some(Err(morpheus::Damage::Header)) => {}
                Some(Err(morpheus::Damage::Checksum { .. })) => self.note(Evidence::Damaged),
                Some(Ok(frame)) if is_from(awaited, frame.source) => {
                    self.reply = Payload::of(Alarms::NONE, frame.data);
                }
                Some(Ok(_)) => self.note(Evidence::Stranger),
            },
            Listener::Stock(parser) => match parser.push(byte) {
                None | Some(Err(protocol1::Damage::Header)) => {}
                Some(Err(protocol1::Damage::Checksum { .. })) => self.note(Evidence::Damaged),
                Some(Ok(frame)) => match Status::decode(&frame) {
                    Some(status) if is_from(awaited, status.id) => {
                        let payload = Payload::of(status.alarms, status.parameters);
                        let position = status.word().filter(|counts| *counts <= 1023);
                        self.status(awaited, payload, position);
                    }
                    _ => self.note(Evidence::Stranger),
                },
            },
        }
    }

    /// A short Morpheus reply to the master.
    fn chain(&mut self, reply: Option<Reply>, ids: [ServoId; JOINTS]) {
        let joint = reply.and_then(|reply| ids.iter().position(|id| id.get() == reply.source));
        let answer = reply.and_then(|reply| match self.awaited {
            Awaited::Positions => reply.position(),
            Awaited::Ping(only) if joint != Some(only) => None,
            Awaited::Ping(_) | Awaited::Pings => reply.is_ping().then_some(0),
            Awaited::Status { .. } | Awaited::Reply(_) => None,
        });
        let slot = joint.and_then(|joint| self.answers.get_mut(joint));
        match (slot, answer) {
            (Some(slot), Some(counts)) => *slot = Some(counts),
            _ => self.note(Evidence::Stranger),
        }
    }

    /// A status packet from whom it was awaited.
    fn status(&mut self, awaited: Awaited, payload: Option<Payload>, position: Option<u16>) {
        self.alarms = payload
            .as_ref()
            .map_or(Alarms::NONE, |payload| payload.alarms);
        if let Awaited::Status {
            joint, parameters, ..
        } = awaited
        {
            let answer = if parameters == 2 { position } else { Some(0) };
            if let Some(slot) = self.answers.get_mut(joint) {
                *slot = answer;
            }
            if answer.is_none() {
                self.note(Evidence::Stranger);
            }
        }
        self.reply = payload;
    }

    /// The receiver reported framing, noise or overrun.
    pub(super) fn line_error(&mut self) {
        self.note(Evidence::LineError);
        match &mut self.listener {
            Listener::Chain(parser) => parser.reset(),
            Listener::Morpheus(parser) => parser.reset(),
            Listener::Stock(parser) => parser.reset(),
        }
    }

    fn note(&mut self, evidence: Evidence) {
        self.evidence = self.evidence.max(evidence);
    }

    fn bytes_held(&self) -> usize {
        match &self.listener {
            Listener::Chain(parser) => parser.bytes_held(),
            Listener::Morpheus(parser) => parser.bytes_held(),
            Listener::Stock(parser) => parser.bytes_held(),
        }
    }

    /// Whether everything awaited has come.
    pub(super) fn is_complete(&self) -> bool {
        match self.awaited {
            Awaited::Ping(joint) | Awaited::Status { joint, .. } => {
                self.answers.get(joint).is_some_and(Option::is_some)
            }
            Awaited::Pings | Awaited::Positions => self.answers.iter().all(Option::is_some),
            Awaited::Reply(_) => self.reply.is_some(),
        }
    }

    /// Bytes that are still to come if all is well, at least one: what else may
    /// be said until then is of no use.
    pub(super) fn bytes_wanted(&self) -> usize {
        let missing = self
            .answers
            .iter()
            .filter(|answer| answer.is_none())
            .count();
        let (replies, len) = match self.awaited {
            Awaited::Ping(_) => (1, PING_LEN),
            Awaited::Pings => (missing, PING_LEN),
            Awaited::Positions => (missing, POSITION_LEN),
            Awaited::Status { parameters, .. } => {
                (1, protocol1::frame::OVERHEAD + usize::from(parameters))
            }
            Awaited::Reply(asked) => (1, asked.reply_bytes.into()),
        };
        (replies * len).saturating_sub(self.bytes_held()).max(1)
    }

    /// Puts down what is known of the joints that were asked. What is missing is
    /// put down to the strongest evidence there is; one servo's silence is told
    /// from a dead bus by the other's answer.
    pub(super) fn settle(
        &self,
        samples: &mut [Sample; JOINTS],
        alarms: &mut [Alarms; JOINTS],
        echo_heard: bool,
        echo_disturbed: bool,
    ) {
        let missing = match self.evidence {
            Evidence::LineError => Missing::Line,
            _ if echo_disturbed => Missing::Line,
            Evidence::Damaged => Missing::BadChecksum,
            Evidence::Stranger => Missing::WrongId,
            Evidence::Bytes if self.bytes_held() > 0 => Missing::Short,
            Evidence::Nothing if echo_heard => Missing::EchoOnly,
            Evidence::Bytes | Evidence::Nothing => Missing::Silence,
        };
        let only = match self.awaited {
            Awaited::Ping(_) | Awaited::Pings | Awaited::Positions => None,
            Awaited::Status { joint, .. } => Some(joint),
            Awaited::Reply(_) => return,
        };
        for (joint, (sample, answer)) in samples.iter_mut().zip(self.answers).enumerate() {
            if only.is_none_or(|only| only == joint) {
                *sample = answer.map_or(Sample::Missing(missing), Sample::Counts);
            }
        }
        if let Some(slot) = only.and_then(|joint| alarms.get_mut(joint)) {
            *slot = self.alarms;
        }
    }

    /// The answer to what was asked, if it came.
    pub(super) fn into_reply(self) -> Option<Payload> {
        self.reply
    }
}

/// Whether this is who was asked.
fn is_from(awaited: Awaited, source: u8) -> bool {
    match awaited {
        Awaited::Status { id, .. } => id == source,
        Awaited::Reply(asked) => asked.id == source,
        Awaited::Ping(_) | Awaited::Pings | Awaited::Positions => false,
    }
}

impl Payload {
    /// `None` if it is longer than any register map.
    fn of(alarms: Alarms, data: &[u8]) -> Option<Self> {
        let data = Vec::from_slice(data).ok()?;
        Some(Self { alarms, data })
    }
}
