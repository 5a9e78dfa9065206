//! What the board tells beside records, and where in its life it belongs.
//!
//! The board sends what it has to say before records that wait, so an
//! acknowledgement may arrive long before the record of the tick that it goes with;
//! once in a while it arrives just after it. What it says of one thing after the
//! other is in order.

use std::collections::VecDeque;

use armbridge_shared::link::message::{Fault, Mode, Moment, Record, Refusal, Settings, Trip};
use armbridge_shared::servo::Firmware;

use super::tick_facts::is_external;

/// Something that has to be done again, or is checked, at its place.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "few wait at a time")]
pub(super) enum Note {
    /// A command was taken.
    Ack {
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Moment,
    },
    /// A motion was asked for.
    Departs { sequence: u16, moment: Moment },
    /// A hello was heard, by a board that works with these settings.
    Began {
        moment: Moment,
        settings: Option<Settings>,
        /// The host had said goodbye before.
        has_left: bool,
    },
    /// Why there is a fault.
    Tripped(Trip),
    /// The servos are lined up.
    Found {
        firmware: Firmware,
        baud: u32,
        is_ready: bool,
    },
    /// A client of the transparent port has the bus.
    Passthrough,
}

/// A place in the board's life: before the tick of a record begins, or after that and
/// before it is decided.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place<'a> {
    Between(&'a Record),
    Within(&'a Record),
    /// After all records.
    End,
}

/// What waits for its place.
#[derive(Debug, Default)]
pub(super) struct Notes(VecDeque<Note>);

impl Notes {
    pub(super) fn push(&mut self, note: Note) {
        self.0.push_back(note);
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Whether a host that said goodbye before is greeted within the tick of this record.
    pub(super) fn has_goodbye(&self, record: &Record) -> bool {
        self.0.iter().any(|note| {
            let is_here = belongs(note, Place::Within(record)) == Some(true);
            is_here && matches!(note, Note::Began { has_left: true, .. })
        })
    }

    /// The next whose place is here, or that was told before an order whose place is. One
    /// that does not say so is here if the next that does is, or if something else shows
    /// that it `is_due`.
    pub(super) fn next(&mut self, place: Place<'_>, is_due: bool) -> Option<Note> {
        let first = self.0.front()?;
        let is_here = belongs(first, place).unwrap_or_else(|| {
            is_due || self.0.iter().find_map(|note| belongs(note, place)) == Some(true)
        });
        // What is told of a fault is told again at a hello, with the tick of old.
        let mut orders = self.0.iter().filter(|it| !matches!(it, Note::Tripped(_)));
        if is_here || orders.any(|note| belongs(note, place) == Some(true)) {
            self.0.pop_front()
        } else {
            None
        }
    }
}

/// Whether this belongs here, or before; `None` if it does not say where.
fn belongs(note: &Note, place: Place<'_>) -> Option<bool> {
    let (tick, is_decided) = match note {
        Note::Ack { moment, .. } | Note::Departs { moment, .. } | Note::Began { moment, .. } => {
            (moment.tick, moment.is_decided)
        }
        Note::Tripped(trip) => return Some(trip_belongs(trip, place)),
        Note::Found { .. } | Note::Passthrough => return None,
    };
    Some(match place {
        Place::Between(record) => is_before(tick, record.tick),
        Place::Within(record) => {
            is_before(tick, record.tick) || (tick == record.tick && !is_decided)
        }
        Place::End => true,
    })
}

/// One from outside is before the decision that it shows in. One of the tick's own is
/// checked when the tick is over; that of a late beginning tells the tick before.
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

/// Whether one tick is before another; their numbers wrap.
pub(super) fn is_before(tick: u32, other: u32) -> bool {
    (tick.wrapping_sub(other) as i32) < 0
}
