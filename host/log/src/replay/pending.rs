//! Pending messages of the board other than records, and their places among the ticks.
//!
//! The board sends messages before queued records, so an
//! acknowledgement may arrive long before the record of its tick;
//! sometimes it arrives just after it. Messages
//! are in order among themselves.

use std::collections::VecDeque;

use armbridge_link::message::{Fault, Mode, Moment, Record, Refusal, Settings, Trip};
use armbridge_servo::Firmware;

use super::tick_facts::is_external;

/// A message that is replayed or checked at its place.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "few wait at a time")]
pub(super) enum PendingMessage {
    /// A command was accepted.
    Ack {
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Moment,
    },
    /// A motion was planned.
    Departs { sequence: u16, moment: Moment },
    /// A hello was received, by a board with these settings.
    Began {
        moment: Moment,
        settings: Option<Settings>,
        /// The previous session ended with a goodbye.
        ended_by_goodbye: bool,
    },
    /// Cause of a fault.
    Tripped(Trip),
    /// The servos are found.
    Found {
        firmware: Firmware,
        baud: u32,
        is_ready: bool,
    },
    /// A client of the transparent port has the bus.
    Passthrough,
}

/// Place among the ticks: before the tick of a record, or within it, before
/// its decision.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place<'a> {
    Between(&'a Record),
    Within(&'a Record),
    /// After all records.
    End,
}

/// Messages that wait at a time. A board sends them some ticks ahead of records; only a log
/// whose ticks are not those of its messages has more, and loses the oldest.
const PENDING_MAX: usize = 1024;

/// Messages that wait for their place.
#[derive(Debug, Default)]
pub(super) struct PendingMessages(VecDeque<PendingMessage>);

impl PendingMessages {
    #[expect(
        clippy::large_types_passed_by_value,
        reason = "it is moved into the queue"
    )]
    pub(super) fn push(&mut self, message: PendingMessage) {
        if self.0.len() == PENDING_MAX {
            self.0.pop_front();
        }
        self.0.push_back(message);
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Whether a host that sent a goodbye sends a hello within the tick of this record.
    pub(super) fn has_goodbye(&self, record: &Record) -> bool {
        self.0.iter().any(|message| {
            let is_due_here = belongs(message, Place::Within(record)) == Some(true);
            is_due_here
                && matches!(
                    message,
                    PendingMessage::Began {
                        ended_by_goodbye: true,
                        ..
                    }
                )
        })
    }

    /// The next message that belongs to this place, or precedes one that does. A message
    /// without a fixed place belongs here if the next one does, or if another event shows
    /// that it `is_due`.
    pub(super) fn next(&mut self, place: Place<'_>, is_due: bool) -> Option<PendingMessage> {
        let first = self.0.front()?;
        let is_due_here = belongs(first, place).unwrap_or_else(|| {
            is_due || self.0.iter().find_map(|message| belongs(message, place)) == Some(true)
        });
        // A trip is repeated after a hello, with its original tick.
        let mut ordered = self
            .0
            .iter()
            .filter(|message| !matches!(message, PendingMessage::Tripped(_)));
        if is_due_here || ordered.any(|message| belongs(message, place) == Some(true)) {
            self.0.pop_front()
        } else {
            None
        }
    }
}

/// Whether a message belongs to this place or an earlier one; `None` if it has no fixed
/// place.
fn belongs(message: &PendingMessage, place: Place<'_>) -> Option<bool> {
    let (tick, is_decided) = match message {
        PendingMessage::Ack { moment, .. }
        | PendingMessage::Departs { moment, .. }
        | PendingMessage::Began { moment, .. } => (moment.tick, moment.is_decided),
        PendingMessage::Tripped(trip) => return Some(trip_belongs(trip, place)),
        PendingMessage::Found { .. } | PendingMessage::Passthrough => return None,
    };
    Some(match place {
        Place::Between(record) => is_before(tick, record.tick),
        Place::Within(record) => {
            is_before(tick, record.tick) || (tick == record.tick && !is_decided)
        }
        Place::End => true,
    })
}

/// A trip from outside precedes the decision that shows it. One of the tick itself is
/// checked after the tick; that of a late start belongs to the tick before.
fn trip_belongs(trip: &Trip, place: Place<'_>) -> bool {
    match place {
        Place::Between(record) => {
            let tick = match trip.fault {
                Fault::Overrun => trip.tick.wrapping_add(1),
                _ => trip.tick,
            };
            is_before(tick, record.tick)
        }
        Place::Within(record) => {
            is_external(trip.fault)
                && trip.tick == record.tick
                && record.mode == Mode::Fault(trip.fault)
        }
        Place::End => true,
    }
}

/// Whether one tick precedes another; their numbers wrap.
pub(super) fn is_before(tick: u32, other: u32) -> bool {
    (tick.wrapping_sub(other) as i32) < 0
}
