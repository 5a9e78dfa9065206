//! Judge of parks: each ends within its bound.

use armbridge_board::tick::limits::PARK_US;
use armbridge_link::message::{Drive, Mode};

use super::outcome::Outcome;

/// Longest time in µs of a park: its bound, a clock that jumps, and the ticks.
pub(super) const ENDS_US: u64 = PARK_US + 300_000;

/// See the [module](self).
#[derive(Debug, Default)]
pub(super) struct ParkJudge {
    /// Time in µs since when the arm is parked.
    since_us: Option<u64>,
}

impl ParkJudge {
    /// Checks the present park, if there is one.
    pub(super) fn observe(&mut self, now_us: u64, mode: Mode, outcome: &mut Outcome) {
        if !is_parking(mode) {
            self.since_us = None;
        } else if now_us > *self.since_us.get_or_insert(now_us) + ENDS_US {
            outcome.fail("the park does not end".into());
        }
    }
}

/// Whether the arm is parked at present.
pub(super) fn is_parking(mode: Mode) -> bool {
    mode.drive() == Some(Drive::Park)
}
