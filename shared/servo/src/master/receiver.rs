//! Receiver of the replies to a request: decodes bytes, and records the cause of missing
//! replies.

use super::super::dispatch::ReplyParser;
use super::super::exchange::{ExpectedReplies, Line, ReplyContent};
use super::super::protocol::{PacketError, Reply};
use super::super::protocol2;
use super::super::{Alarms, ExpectedReply, Firmware, Missing, Sample, ServoIds};
use crate::JOINTS;
use heapless::Vec;

/// Bytes of the longest reply that is decoded: a whole register map of an AX-12A.
const REPLY_MAX: usize = 66;

/// Faults observed during reception, the least specific first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum RxFault {
    /// No byte was received.
    NoBytes,
    /// Bytes that form no packet.
    Bytes,
    /// An intact packet that answers no request.
    UnexpectedReply,
    /// A packet with a wrong checksum.
    BadChecksum,
    /// The UART reported framing, noise or overrun.
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

/// Parser of received bytes, and the replies decoded so far.
#[derive(Debug)]
pub(super) struct Receiver {
    parser: ReplyParser<REPLY_MAX>,
    replies: Replies,
}

/// Decoded replies by joint, and the most specific fault.
#[derive(Debug)]
struct Replies {
    expected: ExpectedReplies,
    firmware: Firmware,
    /// Position of each joint, or 0 for the reply to a ping.
    answers: [Option<u16>; JOINTS],
    /// Servos that are asked, where all are; the answers of the others are not awaited.
    servos: usize,
    /// Alarms in all replies of each addressed servo, with or without a position.
    alarms: [Alarms; JOINTS],
    reply: Option<Payload>,
    /// The most specific fault so far.
    fault: RxFault,
}

impl Default for Receiver {
    /// A receiver that expects nothing.
    fn default() -> Self {
        let nothing = ExpectedReplies::Request(ExpectedReply::NONE);
        Self {
            parser: ReplyParser::new(Firmware::Morpheus),
            replies: Replies {
                expected: nothing,
                firmware: Firmware::Morpheus,
                answers: [None; JOINTS],
                servos: JOINTS,
                alarms: [Alarms::NONE; JOINTS],
                reply: None,
                fault: RxFault::NoBytes,
            },
        }
    }
}

impl Receiver {
    /// Begins a window for these replies of the servos on the line.
    pub(super) fn begin(&mut self, expected: ExpectedReplies, line: &Line) {
        let firmware = match expected {
            ExpectedReplies::Chain(_) => Firmware::Morpheus,
            ExpectedReplies::Servo(..) | ExpectedReplies::Fast | ExpectedReplies::Request(_) => {
                line.firmware
            }
        };
        self.parser = match expected {
            ExpectedReplies::Request(_) => ReplyParser::new(firmware),
            ExpectedReplies::Servo(..) | ExpectedReplies::Chain(_) | ExpectedReplies::Fast => {
                ReplyParser::to_bridge(firmware, firmware.tick_reply_max())
            }
        };
        let replies = &mut self.replies;
        replies.expected = expected;
        replies.firmware = firmware;
        replies.servos = line.ids.len();
        replies.answers = [None; JOINTS];
        for absent in replies.answers.iter_mut().skip(replies.servos) {
            *absent = Some(0);
        }
        replies.alarms = [Alarms::NONE; JOINTS];
        replies.reply = None;
        replies.fault = RxFault::NoBytes;
    }

    /// Takes received bytes that are not our echo.
    pub(super) fn push(&mut self, mut bytes: &[u8], ids: ServoIds) {
        // Found by its parts, which have CRCs of their own.
        let is_fast = self.replies.expected == ExpectedReplies::Fast;
        while let Some((first, rest)) = bytes.split_first() {
            self.replies.note_fault(RxFault::Bytes);
            // The usual case: whole replies, one after the other.
            if !is_fast && let Some((reply, rest)) = self.parser.whole_reply(bytes) {
                self.replies.take(reply, ids);
                bytes = rest;
                continue;
            }
            match self.parser.push(*first) {
                None | Some(Err(PacketError::Header)) => {}
                Some(Ok(_)) if is_fast => {
                    self.replies.take_parts(self.parser.bytes(), ids);
                }
                Some(Err(PacketError::Checksum { .. })) => {
                    self.replies.note_fault(RxFault::BadChecksum);
                }
                Some(Ok(reply)) => self.replies.take(reply, ids),
            }
            bytes = rest;
        }
    }

    /// Records that the UART reported framing, noise or overrun.
    pub(super) fn line_error(&mut self) {
        self.replies.note_fault(RxFault::LineError);
        self.parser.reset();
    }

    /// Whether every expected reply has been received.
    pub(super) fn is_complete(&self) -> bool {
        let Replies { answers, reply, .. } = &self.replies;
        match self.replies.expected {
            ExpectedReplies::Servo(joint, _) => answers.get(joint).is_some_and(Option::is_some),
            ExpectedReplies::Chain(_) | ExpectedReplies::Fast => {
                answers.iter().all(Option::is_some)
            }
            ExpectedReplies::Request(_) => reply.is_some(),
        }
    }

    /// Number of bytes still expected, at least one: an earlier poll completes nothing.
    pub(super) fn bytes_wanted(&self) -> usize {
        let firmware = self.replies.firmware;
        let bytes = |answer| match answer {
            ReplyContent::Pong => firmware.pong_bytes().into(),
            ReplyContent::Position => firmware.reply_overhead() + 2,
        };
        let missing = self
            .replies
            .answers
            .iter()
            .filter(|answer| answer.is_none());
        let expected_bytes = match self.replies.expected {
            ExpectedReplies::Servo(_, answer) => bytes(answer),
            ExpectedReplies::Chain(answer) => missing.count() * bytes(answer),
            ExpectedReplies::Fast => protocol2::positions_bytes(self.replies.servos),
            ExpectedReplies::Request(expected) => expected.reply_bytes.into(),
        };
        expected_bytes
            .saturating_sub(self.parser.bytes_held())
            .max(1)
    }

    /// Takes the whole parts of a fast status packet that a silent servo has left without its end.
    pub(super) fn take_begun_parts(&mut self, ids: ServoIds) {
        if self.replies.expected == ExpectedReplies::Fast && !self.is_complete() {
            self.replies.take_parts(self.parser.bytes(), ids);
        }
    }

    /// Writes the samples and alarms of the addressed joints. A missing sample gets the
    /// most specific fault as its reason; the other servo's reply distinguishes the silence
    /// of one servo from a dead bus.
    pub(super) fn finish(
        &self,
        samples: &mut [Sample; JOINTS],
        alarms: &mut [Alarms; JOINTS],
        is_echoing: bool,
        is_echo_disturbed: bool,
    ) {
        let missing = || match self.replies.fault {
            RxFault::LineError => Missing::Line,
            _ if is_echo_disturbed => Missing::Line,
            RxFault::BadChecksum => Missing::BadChecksum,
            RxFault::UnexpectedReply => Missing::WrongId,
            RxFault::Bytes if self.ends_amid_a_reply() => Missing::Short,
            RxFault::NoBytes if is_echoing => Missing::EchoOnly,
            RxFault::Bytes | RxFault::NoBytes => Missing::Silence,
        };
        let only = match self.replies.expected {
            ExpectedReplies::Chain(_) | ExpectedReplies::Fast => None,
            ExpectedReplies::Servo(joint, _) => Some(joint),
            ExpectedReplies::Request(_) => return,
        };
        let answers = self.replies.answers.into_iter().zip(self.replies.alarms);
        let joints = samples.iter_mut().zip(alarms).zip(answers).enumerate();
        for (joint, ((sample, slot), (answer, alarms))) in joints.take(self.replies.servos) {
            if only.is_none_or(|only| only == joint) {
                *sample = answer.map_or_else(|| Sample::Missing(missing()), Sample::Counts);
                *slot = alarms;
            }
        }
    }

    /// Whether a reply has begun that did not end.
    fn ends_amid_a_reply(&self) -> bool {
        let bytes = self.parser.bytes_held();
        // The servos after the last whole part of a fast status packet are silent.
        let is_fast = self.replies.expected == ExpectedReplies::Fast;
        bytes > 0 && !(is_fast && protocol2::ends_with_part(bytes, self.replies.servos))
    }

    /// The reply to the packet of [`super::Transaction::Request`], if it came.
    pub(super) fn reply(&self) -> Option<&Payload> {
        self.replies.reply.as_ref()
    }

    /// Forgets that reply.
    pub(super) fn forget_reply(&mut self) {
        self.replies.reply = None;
    }
}

impl Replies {
    /// Records a fault, unless a more specific one is recorded.
    fn note_fault(&mut self, fault: RxFault) {
        self.fault = self.fault.max(fault);
    }

    /// Takes an intact packet: a reply, or `None` for what no servo would send.
    fn take(&mut self, reply: Option<Reply<'_>>, ids: ServoIds) {
        let accepted = reply.and_then(|reply| self.accept_reply(&reply, ids));
        if accepted.is_none() {
            self.note_fault(RxFault::UnexpectedReply);
        }
    }

    /// Takes the whole parts of a fast status packet, as far as it has come.
    fn take_parts(&mut self, packet: &[u8], ids: ServoIds) {
        for part in protocol2::position_parts(packet) {
            let Ok(part) = part else {
                return self.note_fault(RxFault::BadChecksum);
            };
            let joint = ids.joint(part.id);
            let slots = joint.and_then(|joint| {
                Some((self.answers.get_mut(joint)?, self.alarms.get_mut(joint)?))
            });
            let Some((answer, alarms)) = slots else {
                self.note_fault(RxFault::UnexpectedReply);
                continue;
            };
            *alarms = alarms.or(part.alarms());
            *answer = self.firmware.position(part.data);
        }
    }

    /// Takes a reply; `None` if it is not expected.
    fn accept_reply(&mut self, reply: &Reply, ids: ServoIds) -> Option<()> {
        let joint = ids.joint(reply.id);
        let (joint, answer) = match self.expected {
            ExpectedReplies::Request(expected) if expected.id != reply.id => return None,
            ExpectedReplies::Request(_) => {
                self.reply = Some(Payload {
                    alarms: reply.alarms,
                    // At most a whole register map.
                    data: Vec::from_slice(reply.data).ok()?,
                });
                return Some(());
            }
            // By their parts.
            ExpectedReplies::Fast => return None,
            ExpectedReplies::Servo(only, _) if joint != Some(only) => return None,
            ExpectedReplies::Servo(_, answer) | ExpectedReplies::Chain(answer) => (joint?, answer),
        };
        let alarms = self.alarms.get_mut(joint)?;
        *alarms = alarms.or(reply.alarms);
        let counts = match answer {
            ReplyContent::Pong => self.firmware.is_pong(reply.data).then_some(0),
            ReplyContent::Position => self.firmware.position(reply.data),
        };
        *self.answers.get_mut(joint)? = Some(counts?);
        Some(())
    }
}
