//! State of a replay between two events, as bytes.

use std::collections::HashMap;

use armbridge_board::tick::ControlLoop;
use armbridge_board::tick::reference::StartPoint;
use armbridge_link::message::{Command, Moment, Record, Settings};
use serde::{Deserialize, Serialize};

use super::super::board::Board;
use super::super::edits::Edit;
use super::super::what_if;
use super::{Changes, Knowledge, ReplayError, Replayer};

/// State of a replay.
#[derive(Serialize, Deserialize)]
struct State {
    settings: Settings,
    reported: Option<Settings>,
    control_loop: ControlLoop,
    commands: Vec<(u16, Command)>,
    start_points: Vec<(u16, StartPoint)>,
    edits: Vec<(Moment, Edit)>,
    waiting: Option<Record>,
    last: Record,
}

impl Replayer {
    /// Start of the last tick that was replayed, in µs, if the state behind it is known.
    pub(in crate::replay) fn known_until_us(&self) -> Option<u64> {
        let last = self.last.filter(|_| self.knowledge == Knowledge::Full)?;
        Some(last.input.start_us)
    }

    /// The state, if it is known, in an encoding of this build.
    pub(in crate::replay) fn state(&self) -> Option<Vec<u8>> {
        let last = self.last.filter(|_| self.knowledge == Knowledge::Full)?;
        let state = State {
            settings: self.settings,
            reported: self.reported,
            control_loop: self.board.control_loop().clone(),
            commands: sorted(&self.commands),
            start_points: sorted(&self.start_points),
            edits: self.edits.all(),
            waiting: self.waiting,
            last,
        };
        postcard::to_stdvec(&state).ok()
    }

    /// A replay from a state on, as in a snapshot; `None` if another build has encoded it.
    ///
    /// # Errors
    /// If the changed settings are not valid.
    pub fn resume(state: &[u8], changes: Changes) -> Result<Option<Self>, ReplayError> {
        let Ok((state, [])) = postcard::take_from_bytes::<State>(state) else {
            return Ok(None);
        };
        let mut replayer = Self::new(changes)?;
        let settings = replayer.changes.apply(&state.settings)?;
        let changed = what_if::changed(&state.settings, &settings);
        replayer.changed.extend(changed);
        let board = Board::resume(state.control_loop, &settings);
        replayer.board = board.map_err(ReplayError::Settings)?;
        replayer.settings = settings;
        replayer.reported = state.reported;
        replayer.knowledge = Knowledge::Full;
        replayer.commands = state.commands.into_iter().collect();
        replayer.start_points = state.start_points.into_iter().collect();
        for (moment, edit) in state.edits {
            replayer.edits.push(moment, edit);
        }
        replayer.waiting = state.waiting;
        replayer.last = Some(state.last);
        Ok(Some(replayer))
    }
}

/// The entries of a map, so that equal states have equal bytes.
fn sorted<T: Clone>(map: &HashMap<u16, T>) -> Vec<(u16, T)> {
    let entries = map.iter().map(|(key, value)| (*key, value.clone()));
    let mut entries: Vec<_> = entries.collect();
    entries.sort_unstable_by_key(|(key, _)| *key);
    entries
}
