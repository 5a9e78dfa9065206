//! How experiments ended: as the board told, and as it came out.
//!
//! The board tells it in the tick in which it is so, most often before that tick's
//! record; so both wait for each other, by the number of the tick.

use std::collections::VecDeque;

use armbridge_client::experiment_text;
use armbridge_shared::link::experiment::{Conclusion, ExperimentEnd};
use armbridge_shared::link::message::Record;

use super::super::board::Board;
use super::super::compare::Difference;
use super::super::pending::is_before;
use super::Replayer;

/// Ends of experiments that wait for the other side's.
#[derive(Debug, Default)]
pub(super) struct Conclusions {
    told: VecDeque<Conclusion>,
    computed: VecDeque<Conclusion>,
}

impl Conclusions {
    /// The board told this.
    pub(super) fn receive(&mut self, conclusion: Conclusion) {
        self.told.push_back(conclusion);
    }

    /// Whether an experiment ended in this tick for a reason that was decided again,
    /// and not because the host was quiet, which nobody can know.
    pub(super) fn is_by_itself(&mut self, board: &mut Board, tick: u32) -> bool {
        while let Some(conclusion) = board.take_conclusion() {
            self.computed.push_back(conclusion);
        }
        let last = self.computed.back().filter(|last| last.tick == tick);
        last.is_some_and(|last| last.end != ExperimentEnd::HostQuiet)
    }

    /// The next pair of one tick. What has no partner up to this tick was told, or came
    /// out, where not everything is known.
    fn next_pair(&mut self, tick: u32) -> Option<(Conclusion, Conclusion)> {
        loop {
            let (told, computed) = (*self.told.front()?, *self.computed.front()?);
            if told.tick == computed.tick {
                self.told.pop_front();
                self.computed.pop_front();
                return Some((told, computed));
            }
            let behind = if is_before(told.tick, computed.tick) {
                &mut self.told
            } else {
                &mut self.computed
            };
            if behind.front().is_some_and(|it| is_before(tick, it.tick)) {
                return None;
            }
            behind.pop_front();
        }
    }
}

impl Replayer {
    /// Compares what was told of experiments up to this record with what came out.
    pub(super) fn check_conclusions(&mut self, record: &Record) {
        while let Some((told, computed)) = self.conclusions.next_pair(record.tick) {
            if !self.is_known() {
                continue;
            }
            self.tally.answers += 1;
            if told == computed {
                continue;
            }
            self.tally.answers_differing += 1;
            self.tally.differ(|| {
                Some(Difference {
                    tick: told.tick,
                    start_us: record.start_us,
                    field: "end of the experiment".into(),
                    recorded: experiment_text::conclusion(&told),
                    computed: experiment_text::conclusion(&computed),
                })
            });
        }
    }
}
