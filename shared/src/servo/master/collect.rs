//! Replies received while the master listens, and the reasons for those that are
//! missing.

use super::super::dispatch::ReplyParser;
use super::super::exchange::{Answer, Awaited};
use super::super::protocol::{Damage, Reply};
use super::super::protocol1::Alarms;
use super::super::{Firmware, Missing, Sample, ServoId};
use crate::JOINTS;
use heapless::Vec;

/// Bytes of the longest reply that is taken apart: a whole register map.
const REPLY_MAX: usize = 66;

/// Evidence about missing replies, weakest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Evidence {
    Nothing,
    /// Bytes.
    Bytes,
    /// An intact packet that answers no request.
    Stranger,
    /// A packet with a wrong checksum.
    Damaged,
    /// The receiver reported framing, noise or overrun.
    LineError,
}

/// A reply's payload, with the error byte of a stock servo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Payload {
    /// Alarms of a stock servo.
    pub alarms: Alarms,
    /// Parameters or data.
    pub data: Vec<u8, REPLY_MAX>,
}

/// Replies sorted by joint, and evidence about those that did not come.
#[derive(Debug)]
pub(super) struct Collect {
    parser: ReplyParser<REPLY_MAX>,
    found: Found,
}

#[derive(Debug)]
struct Found {
    awaited: Awaited,
    firmware: Firmware,
    /// Position, or 0 for a ping's answer.
    answers: [Option<u16>; JOINTS],
    /// Of every reply of the servo that was asked, with or without an answer in it.
    alarms: Alarms,
    reply: Option<Payload>,
    /// The strongest so far.
    evidence: Evidence,
}

impl Collect {
    pub(super) fn new(awaited: Awaited, firmware: Firmware) -> Self {
        let firmware = match awaited {
            Awaited::Each(_) => Firmware::Morpheus,
            Awaited::One(..) | Awaited::Reply(_) => firmware,
        };
        Self {
            parser: match awaited {
                Awaited::Reply(_) => ReplyParser::new(firmware),
                Awaited::One(..) | Awaited::Each(_) => {
                    ReplyParser::to_bridge(firmware, firmware.tick_reply_max())
                }
            },
            found: Found {
                awaited,
                firmware,
                answers: [None; JOINTS],
                alarms: Alarms::NONE,
                reply: None,
                evidence: Evidence::Nothing,
            },
        }
    }

    /// A byte that is not our echo.
    pub(super) fn byte(&mut self, byte: u8, ids: [ServoId; JOINTS]) {
        self.found.note(Evidence::Bytes);
        match self.parser.push(byte) {
            None | Some(Err(Damage::Header)) => {}
            Some(Err(Damage::Checksum { .. })) => self.found.note(Evidence::Damaged),
            Some(Ok(reply)) => {
                let accepted = reply.and_then(|reply| self.found.accept(&reply, ids));
                if accepted.is_none() {
                    self.found.note(Evidence::Stranger);
                }
            }
        }
    }

    /// The receiver reported framing, noise or overrun.
    pub(super) fn line_error(&mut self) {
        self.found.note(Evidence::LineError);
        self.parser.reset();
    }

    /// Whether everything awaited has come.
    pub(super) fn is_complete(&self) -> bool {
        let Found { answers, reply, .. } = &self.found;
        match self.found.awaited {
            Awaited::One(joint, _) => answers.get(joint).is_some_and(Option::is_some),
            Awaited::Each(_) => answers.iter().all(Option::is_some),
            Awaited::Reply(_) => reply.is_some(),
        }
    }

    /// Bytes that are still to come if all is well, at least one: polling before
    /// they are there is of no use.
    pub(super) fn bytes_wanted(&self) -> usize {
        let firmware = self.found.firmware;
        let bytes = |answer| match answer {
            Answer::Pong => firmware.pong_bytes().into(),
            Answer::Position => firmware.reply_overhead() + 2,
        };
        let missing = self.found.answers.iter().filter(|answer| answer.is_none());
        let all = match self.found.awaited {
            Awaited::One(_, answer) => bytes(answer),
            Awaited::Each(answer) => missing.count() * bytes(answer),
            Awaited::Reply(expected) => expected.reply_bytes.into(),
        };
        all.saturating_sub(self.parser.bytes_held()).max(1)
    }

    /// Writes down the samples of the joints that were asked. A missing one is put
    /// down to the strongest evidence there is; one servo's silence is distinguished from a
    /// dead bus by the other's answer.
    pub(super) fn settle(
        &self,
        samples: &mut [Sample; JOINTS],
        alarms: &mut [Alarms; JOINTS],
        echo_heard: bool,
        echo_disturbed: bool,
    ) {
        let missing = match self.found.evidence {
            Evidence::LineError => Missing::Line,
            _ if echo_disturbed => Missing::Line,
            Evidence::Damaged => Missing::BadChecksum,
            Evidence::Stranger => Missing::WrongId,
            Evidence::Bytes if self.parser.bytes_held() > 0 => Missing::Short,
            Evidence::Nothing if echo_heard => Missing::EchoOnly,
            Evidence::Bytes | Evidence::Nothing => Missing::Silence,
        };
        let only = match self.found.awaited {
            Awaited::Each(_) => None,
            Awaited::One(joint, _) => Some(joint),
            Awaited::Reply(_) => return,
        };
        for (joint, (sample, answer)) in samples.iter_mut().zip(self.found.answers).enumerate() {
            if only.is_none_or(|only| only == joint) {
                *sample = answer.map_or(Sample::Missing(missing), Sample::Counts);
            }
        }
        if let Some(slot) = only.and_then(|joint| alarms.get_mut(joint)) {
            *slot = self.found.alarms;
        }
    }

    /// The reply to the packet of [`super::Transaction::Ask`], if it came.
    pub(super) fn into_reply(self) -> Option<Payload> {
        self.found.reply
    }
}

impl Found {
    fn note(&mut self, evidence: Evidence) {
        self.evidence = self.evidence.max(evidence);
    }

    /// Takes a reply that is awaited; `None` if it is not.
    fn accept(&mut self, reply: &Reply, ids: [ServoId; JOINTS]) -> Option<()> {
        let joint = ids.iter().position(|id| id.get() == reply.id);
        let (joint, answer) = match self.awaited {
            Awaited::Reply(expected) if expected.id != reply.id => return None,
            Awaited::Reply(_) => {
                self.reply = Some(Payload {
                    alarms: reply.alarms,
                    // No longer than any register map.
                    data: Vec::from_slice(reply.data).ok()?,
                });
                return Some(());
            }
            Awaited::One(only, _) if joint != Some(only) => return None,
            Awaited::One(_, answer) | Awaited::Each(answer) => (joint?, answer),
        };
        self.alarms = self.alarms.or(reply.alarms);
        let counts = match answer {
            Answer::Pong => self.firmware.is_pong(reply.data).then_some(0),
            Answer::Position => self.firmware.position(reply.data),
        };
        *self.answers.get_mut(joint)? = Some(counts?);
        Some(())
    }
}
