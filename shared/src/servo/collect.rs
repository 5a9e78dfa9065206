//! What came back while the master listened.

use super::morpheus::{Parser, Reply, ServoId};
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

/// Replies sorted by joint, and evidence about those that did not come.
#[derive(Debug)]
pub(super) struct Collect {
    awaited: Awaited,
    parser: Parser,
    /// Position, or 0 for a ping's answer.
    answers: [Option<u16>; JOINTS],
    heard_anything: bool,
    bad_checksum: bool,
    wrong_id: bool,
    line_error: bool,
}

impl Collect {
    pub(super) fn new(awaited: Awaited) -> Self {
        Self {
            awaited,
            parser: Parser::default(),
            answers: [None; JOINTS],
            heard_anything: false,
            bad_checksum: false,
            wrong_id: false,
            line_error: false,
        }
    }

    /// A byte that is not our echo.
    pub(super) fn byte(&mut self, byte: u8, ids: [ServoId; JOINTS]) {
        self.heard_anything = true;
        match self.parser.push(byte) {
            None => {}
            Some(Err(_)) => self.bad_checksum = true,
            Some(Ok(reply)) => self.reply(&reply, ids),
        }
    }

    fn reply(&mut self, reply: &Reply, ids: [ServoId; JOINTS]) {
        let Some(joint) = ids.iter().position(|id| id.get() == reply.source) else {
            self.wrong_id = true;
            return;
        };
        let answer = match self.awaited {
            Awaited::Positions => reply.position(),
            Awaited::Ping(only) if only != joint => {
                self.wrong_id = true;
                return;
            }
            Awaited::Ping(_) | Awaited::Pings => reply.is_ping().then_some(0),
        };
        match (self.answers.get_mut(joint), answer) {
            (Some(slot), Some(counts)) => *slot = Some(counts),
            // An intact packet with contents that nobody asked for.
            _ => self.wrong_id = true,
        }
    }

    /// The receiver reported framing, noise or overrun.
    pub(super) fn line_error(&mut self) {
        self.line_error = true;
        self.parser.reset();
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
        let missing = if self.line_error || echo_disturbed {
            Missing::Line
        } else if self.bad_checksum {
            Missing::BadChecksum
        } else if self.wrong_id {
            Missing::WrongId
        } else if self.parser.bytes_held() > 0 {
            Missing::Short
        } else if echo_heard && !self.heard_anything {
            Missing::EchoOnly
        } else {
            Missing::Silence
        };
        self.answers
            .map(|answer| answer.map_or(Sample::Missing(missing), Sample::Counts))
    }
}
