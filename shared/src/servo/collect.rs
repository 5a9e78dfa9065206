//! What came back while the master listened.

use super::morpheus::{Damage, MASTER, Parser, Reply, ServoId};
use crate::JOINTS;
use crate::link::message::{Missing, Sample};

/// Length of the answer to a ping, and of a position.
const PING_LEN: usize = 6;
const POSITION_LEN: usize = 7;

/// Which replies are awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Awaited {
    /// A ping's answer from the servo of this joint.
    Ping(usize),
    /// A ping's answer from every servo.
    Pings,
    /// A position from every servo.
    Positions,
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

/// Replies sorted by joint, and evidence about those that did not come.
#[derive(Debug)]
pub(super) struct Collect {
    awaited: Awaited,
    parser: Parser,
    /// Position, or 0 for a ping's answer.
    answers: [Option<u16>; JOINTS],
    /// The strongest so far.
    evidence: Evidence,
}

impl Collect {
    pub(super) fn new(awaited: Awaited) -> Self {
        Self {
            awaited,
            parser: Parser::to(MASTER),
            answers: [None; JOINTS],
            evidence: Evidence::Nothing,
        }
    }

    /// A byte that is not our echo.
    pub(super) fn byte(&mut self, byte: u8, ids: [ServoId; JOINTS]) {
        self.note(Evidence::Bytes);
        match self
            .parser
            .push(byte)
            .map(|found| found.map(|frame| Reply::of(&frame)))
        {
            None | Some(Err(Damage::Header)) => {}
            Some(Err(Damage::Checksum { .. })) => self.note(Evidence::Damaged),
            Some(Ok(Some(reply))) => self.reply(&reply, ids),
            Some(Ok(None)) => self.note(Evidence::Stranger),
        }
    }

    fn reply(&mut self, reply: &Reply, ids: [ServoId; JOINTS]) {
        let joint = ids.iter().position(|id| id.get() == reply.source);
        let answer = match self.awaited {
            Awaited::Positions => reply.position(),
            Awaited::Ping(only) if joint != Some(only) => None,
            Awaited::Ping(_) | Awaited::Pings => reply.is_ping().then_some(0),
        };
        let slot = joint.and_then(|joint| self.answers.get_mut(joint));
        match (slot, answer) {
            (Some(slot), Some(counts)) => *slot = Some(counts),
            _ => self.note(Evidence::Stranger),
        }
    }

    /// The receiver reported framing, noise or overrun.
    pub(super) fn line_error(&mut self) {
        self.note(Evidence::LineError);
        self.parser.reset();
    }

    fn note(&mut self, evidence: Evidence) {
        self.evidence = self.evidence.max(evidence);
    }

    /// Whether everything awaited has come.
    pub(super) fn is_complete(&self) -> bool {
        match self.awaited {
            Awaited::Ping(joint) => self.answers.get(joint).is_some_and(Option::is_some),
            Awaited::Pings | Awaited::Positions => self.answers.iter().all(Option::is_some),
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
        };
        (replies * len)
            .saturating_sub(self.parser.bytes_held())
            .max(1)
    }

    /// One sample a joint. What is missing is put down to the strongest
    /// evidence there is; one servo's silence is told from a dead bus by the
    /// other's answer.
    pub(super) fn samples(&self, echo_heard: bool, echo_disturbed: bool) -> [Sample; JOINTS] {
        let missing = match self.evidence {
            Evidence::LineError => Missing::Line,
            _ if echo_disturbed => Missing::Line,
            Evidence::Damaged => Missing::BadChecksum,
            Evidence::Stranger => Missing::WrongId,
            Evidence::Bytes if self.parser.bytes_held() > 0 => Missing::Short,
            Evidence::Nothing if echo_heard => Missing::EchoOnly,
            Evidence::Bytes | Evidence::Nothing => Missing::Silence,
        };
        self.answers
            .map(|answer| answer.map_or(Sample::Missing(missing), Sample::Counts))
    }
}
