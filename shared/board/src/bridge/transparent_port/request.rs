//! Requests of the client, as queries of the board on the bus.
//!
//! While a control loop runs, the bus is free for a part of each tick only. A
//! query is sent only if its answer is sure to end in time. A read
//! that is longer than that is done in pieces, over as many ticks as it takes, and the
//! client gets one answer: all the bytes, and the alarms of all pieces.
//!
//! Duration of one query at 1 Mbaud, if servos begin to answer within 100 µs:
//!
//! | query                             | sent  | answered | in all |
//! |-----------------------------------|-------|----------|--------|
//! | PING, either firmware             | 60 µs | 60 µs    | 220 µs |
//! | stock READ of two bytes           | 80 µs | 80 µs    | 260 µs |
//! | stock READ of the whole table     | 80 µs | 560 µs   | 740 µs |
//! | Morpheus READ of the temperature  | 80 µs | 90 µs    | 270 µs |
//! | Morpheus READ of the whole EEPROM | 80 µs | 160 µs   | 340 µs |

mod register_read;

pub use register_read::BusQuery;
pub(super) use register_read::RegisterRead;

use super::response::{Bytes, Responder};
use crate::sequencer::TimeBudget;
use armbridge_servo::Alarms;

/// Progress of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Another query is needed.
    More,
    /// Done, with the answer for the client. Empty where servos give none.
    Done(Bytes),
    /// Done without an answer, or without one that fits the request. The client gets none
    /// either.
    Silent,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Queries {
    /// One query, whose answer goes to the client as it is.
    Single(BusQuery),
    /// One query for each piece of a read.
    Read(RegisterRead),
}

/// A request of the client that is under way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PendingRequest {
    responder: Responder,
    queries: Queries,
    /// Alarms in all answers so far.
    alarms: Alarms,
}

impl PendingRequest {
    /// A request that one query answers, not a READ.
    pub(super) fn single(responder: Responder, query: BusQuery) -> Self {
        Self {
            responder,
            queries: Queries::Single(query),
            alarms: Alarms::NONE,
        }
    }

    /// A READ, with a query for each piece of it.
    pub(super) fn read(responder: Responder, read: RegisterRead) -> Self {
        Self {
            responder,
            queries: Queries::Read(read),
            alarms: Alarms::NONE,
        }
    }

    /// The next query, of at most the length that fits; `None` if none
    /// fits. Its answer goes to [`PendingRequest::take_reply`].
    pub fn next(&mut self, budget: TimeBudget) -> Option<BusQuery> {
        match &mut self.queries {
            Queries::Single(query) => budget.fits(query).then(|| query.clone()),
            Queries::Read(read) => read.next(budget.bytes()),
        }
    }

    /// Whether repeated slots of this time complete the request.
    /// If not, [`PendingRequest::refusal`] is the answer.
    pub fn can_complete(&self, budget: TimeBudget) -> bool {
        match &self.queries {
            Queries::Single(query) => budget.fits(query),
            Queries::Read(read) => read.can_complete(budget.bytes()),
        }
    }

    /// Takes the reply to the last query: error byte, which has no
    /// meaning for Morpheus, and parameters. `None` if there was none.
    pub fn take_reply(&mut self, reply: Option<(u8, &[u8])>) -> Progress {
        let Some((error, data)) = reply else {
            return match &self.queries {
                Queries::Single(BusQuery { reply_bytes: 0, .. }) => Progress::Done(Bytes::new()),
                Queries::Single(_) | Queries::Read(_) => Progress::Silent,
            };
        };
        self.alarms = self.alarms.or(Alarms::from_bits(error));
        let Queries::Read(read) = &mut self.queries else {
            return Progress::Done(self.responder.reply(self.alarms, data));
        };
        if read.take_data(data) {
            if !read.is_complete() {
                return Progress::More;
            }
            Progress::Done(self.responder.reply(self.alarms, read.data()))
        } else if data == self.responder.firmware.refusal() {
            Progress::Done(self.responder.reply(self.alarms, data))
        } else {
            Progress::Silent
        }
    }

    /// Id of the servo that is queried.
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
