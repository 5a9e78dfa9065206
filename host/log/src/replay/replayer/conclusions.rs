//! Ends of experiments: as reported by the board, and as computed.
//!
//! The board reports an end in its tick, usually before that tick's record; so reports and
//! computed ends are matched by the number of the tick.

use std::collections::VecDeque;

use armbridge_client::experiment_text;
use armbridge_link::experiment::{Conclusion, ExperimentEnd};
use armbridge_link::message::Record;

use super::super::board::Board;
use super::super::compare::Difference;
use super::super::pending::is_before;
use super::Replayer;

/// Ends of experiments without their counterparts so far.
#[derive(Debug, Default)]
pub(super) struct Conclusions {
    reported: VecDeque<Conclusion>,
    computed: VecDeque<Conclusion>,
}

impl Conclusions {
    /// Adds a report of the board.
    pub(super) fn receive(&mut self, conclusion: Conclusion) {
        self.reported.push_back(conclusion);
    }

    /// Whether an experiment ended in this tick for a computed reason,
    /// and not because of the host's silence, which is not recorded.
    pub(super) fn ended_by_board(&mut self, board: &mut Board, tick: u32) -> bool {
        while let Some(conclusion) = board.take_conclusion() {
            self.computed.push_back(conclusion);
        }
        let last = self.computed.back().filter(|last| last.tick == tick);
        last.is_some_and(|last| last.end != ExperimentEnd::HostQuiet)
    }

    /// The next pair of one tick. Entries without a counterpart up to this tick are from
    /// times of incomplete knowledge.
    fn next_pair(&mut self, tick: u32) -> Option<(Conclusion, Conclusion)> {
        loop {
            let (reported, computed) = (*self.reported.front()?, *self.computed.front()?);
            if reported.tick == computed.tick {
                self.reported.pop_front();
                self.computed.pop_front();
                return Some((reported, computed));
            }
            let behind = if is_before(reported.tick, computed.tick) {
                &mut self.reported
            } else {
                &mut self.computed
            };
            if behind.front().is_some_and(|end| is_before(tick, end.tick)) {
                return None;
            }
            behind.pop_front();
        }
    }
}

impl Replayer {
    /// Compares the reports up to this record with the computed ends.
    pub(super) fn check_conclusions(&mut self, record: &Record) {
        while let Some((reported, computed)) = self.conclusions.next_pair(record.tick) {
            if !self.is_known() {
                continue;
            }
            self.tally.answers += 1;
            if reported == computed {
                continue;
            }
            self.tally.answers_differing += 1;
            self.tally.differ(|| {
                Some(Difference {
                    tick: reported.tick,
                    start_us: record.start_us,
                    field: "end of the experiment".into(),
                    recorded: experiment_text::conclusion(&reported),
                    computed: experiment_text::conclusion(&computed),
                })
            });
        }
    }
}
