//! Changes of the loop's state between ticks, and their places among the ticks.
//!
//! The board sends messages before queued records, so an acknowledgement may arrive long
//! before the record of its tick; sometimes it arrives just after it. Messages are in order
//! among themselves.

use std::collections::VecDeque;

use armbridge_link::message::{Moment, Refusal, Settings};
use serde::{Deserialize, Serialize};

/// A change, or a refusal of one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Edit {
    /// A command was accepted or refused.
    Answer {
        sequence: u16,
        result: Result<(), Refusal>,
    },
    /// The start point of a motion was taken.
    Departs { sequence: u16 },
    /// A hello was received, by a board with these settings.
    Began { settings: Option<Box<Settings>> },
}

/// Edits that wait at a time. A board sends them some ticks ahead of records; only a log
/// whose ticks are not those of its messages has more, and loses the oldest.
const EDITS_MAX: usize = 1024;

/// Edits that wait for their place.
#[derive(Debug, Default)]
pub(super) struct Edits(VecDeque<(Moment, Edit)>);

impl Edits {
    pub(super) fn push(&mut self, moment: Moment, edit: Edit) {
        if self.0.len() == EDITS_MAX {
            self.0.pop_front();
        }
        self.0.push_back((moment, edit));
    }

    /// Those that wait, in order.
    pub(super) fn all(&self) -> Vec<(Moment, Edit)> {
        self.0.iter().cloned().collect()
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// The next edit that precedes the decision of this tick, or that precedes one that does;
    /// any without a tick.
    pub(super) fn next(&mut self, tick: Option<u32>) -> Option<(Moment, Edit)> {
        let precedes = |moment: &Moment| {
            tick.is_none_or(|tick| {
                is_before(moment.tick, tick) || (moment.tick == tick && !moment.is_decided)
            })
        };
        let is_due = self.0.iter().any(|(moment, _)| precedes(moment));
        if is_due { self.0.pop_front() } else { None }
    }
}

/// Whether one tick precedes another; their numbers wrap.
pub(super) fn is_before(tick: u32, other: u32) -> bool {
    (tick.wrapping_sub(other) as i32) < 0
}
