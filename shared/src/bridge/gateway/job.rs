//! What the client asked, as requests that the board itself puts on the bus.
//!
//! While a control loop runs, the bus is free for a part of each tick only. A
//! request goes out only if its answer is sure to be over by then. A reading
//! that is longer than that is done in pieces, over as many ticks as it takes,
//! and the client gets one answer: all the bytes, and the alarms of all pieces.
//!
//! What one request takes at 1 Mbaud, if servos begin to answer within 100 µs:
//!
//! | request                           | sent  | answered | in all |
//! |-----------------------------------|-------|----------|--------|
//! | PING, either firmware             | 60 µs | 60 µs    | 220 µs |
//! | stock READ of two bytes           | 80 µs | 80 µs    | 260 µs |
//! | stock READ of the whole table     | 80 µs | 560 µs   | 740 µs |
//! | Morpheus READ of the temperature  | 80 µs | 90 µs    | 270 µs |
//! | Morpheus READ of the whole EEPROM | 80 µs | 160 µs   | 340 µs |

mod reading;

pub(super) use reading::Reading;

use super::response::{BYTES_MAX, Bytes, Responder};
use crate::servo::Query;
use crate::servo::protocol1::Alarms;

/// One request for the bus.
pub type Ask = Query<BYTES_MAX>;

/// Where a job stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Another request is needed.
    More,
    /// Over: the answer for the client. Empty where servos give none.
    Done(Bytes),
    /// Over: no answer came, or none that fits the request. The client hears
    /// nothing either.
    Silent,
}

/// How long the bus is free, and how long things take there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slack {
    /// Until the answer must be over.
    pub budget_us: u32,
    /// One byte on the wire.
    pub byte_ns: u32,
    /// From the end of a request until a servo begins to answer, at most. Of a
    /// stock servo: its return delay, 500 µs ex works, and what it needs beyond.
    pub latency_us: u32,
}

impl Slack {
    /// How many bytes of request and answer there is time for.
    fn bytes(self) -> usize {
        let speaking_us = self.budget_us.saturating_sub(self.latency_us);
        let bytes = u64::from(speaking_us) * 1_000 / u64::from(self.byte_ns.max(1));
        usize::try_from(bytes).unwrap_or(usize::MAX)
    }

    /// Whether a request and its answer are sure to be over.
    pub(in crate::bridge) fn has_time_for(self, ask: &Ask) -> bool {
        ask.packet.len() + usize::from(ask.reply_bytes) <= self.bytes()
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Task {
    /// One request, whose answer goes to the client as it is.
    Single(Ask),
    /// As many as it takes.
    Read(Reading),
}

/// One thing that the client asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    responder: Responder,
    task: Task,
    /// Of all answers so far.
    alarms: Alarms,
}

impl Job {
    /// One request that is not a READ.
    pub(super) fn single(responder: Responder, ask: Ask) -> Self {
        Self {
            responder,
            task: Task::Single(ask),
            alarms: Alarms::NONE,
        }
    }

    /// A reading, with a request for each piece of it.
    pub(super) fn read(responder: Responder, reading: Reading) -> Self {
        Self {
            responder,
            task: Task::Read(reading),
            alarms: Alarms::NONE,
        }
    }

    /// The next request, as long as there is time for; `None` if there is not
    /// time enough for any. Its answer goes to [`Job::took`].
    pub fn next(&mut self, slack: Slack) -> Option<Ask> {
        match &mut self.task {
            Task::Single(ask) => slack.has_time_for(ask).then(|| ask.clone()),
            Task::Read(reading) => reading.next(slack.bytes()),
        }
    }

    /// Whether it comes to an end if there is so much time again and again.
    /// If not, [`Job::refusal`] is the answer.
    pub fn can_ever_fit(&self, slack: Slack) -> bool {
        match &self.task {
            Task::Single(ask) => slack.has_time_for(ask),
            Task::Read(reading) => reading.can_ever_fit(slack.bytes()),
        }
    }

    /// Takes what came back to the last request: error byte, which has no
    /// meaning for Morpheus, and parameters. `None` if nothing did.
    pub fn took(&mut self, reply: Option<(u8, &[u8])>) -> Progress {
        let Some((error, data)) = reply else {
            return match &self.task {
                Task::Single(Ask { reply_bytes: 0, .. }) => Progress::Done(Bytes::new()),
                Task::Single(_) | Task::Read(_) => Progress::Silent,
            };
        };
        self.alarms = self.alarms.or(Alarms::from_bits(error));
        let Task::Read(reading) = &mut self.task else {
            return Progress::Done(self.responder.reply(self.alarms, data));
        };
        if reading.took(data) {
            if !reading.is_complete() {
                return Progress::More;
            }
            Progress::Done(self.responder.reply(self.alarms, reading.data()))
        } else if data == self.responder.firmware.refusal() {
            Progress::Done(self.responder.reply(self.alarms, data))
        } else {
            Progress::Silent
        }
    }

    /// The id of the servo that is asked.
    pub fn servo(&self) -> u8 {
        self.responder.id
    }

    /// The refusal in the servo's name.
    pub fn refusal(&self) -> Bytes {
        self.responder.refusal()
    }
}

#[cfg(test)]
mod tests;
