//! A log that was written, read back as a whole.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use armbridge_shared::link::message::{Record, Settings, ToHost};

pub use super::reader::Reader;
use crate::run_info::RunFacts;
use armbridge_client::event::{Event, EventKind};

/// All of a log.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Where it was read from.
    pub path: PathBuf,
    /// Of the run, with the settings that the board told last.
    pub facts: RunFacts,
    /// With which it first drove its motors: told last before that; those told last, if it
    /// never drove them, and none if it never told any.
    pub settings: Option<Settings>,
    /// Everything that was said, in order, records too.
    pub events: Vec<Event>,
    /// What is missing of the file, each in one sentence; empty for an intact one.
    pub damage: Vec<String>,
    /// Metadata by name and key, such as `build`, `git`; see
    /// [`metadata`](super::metadata).
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
}

/// Why a log cannot be read at all.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {path}: {why}", path = path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Why, and what to do.
    pub why: String,
}

impl Recording {
    /// Reads a log as far as it goes; a folder means the log in it. An hour at 1 kHz takes gigabytes of memory:
    /// [`Reader`] does with some megabytes.
    ///
    /// # Errors
    /// When there is nothing that can be read.
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        let mut reader = Reader::open(path)?;
        let events: Vec<Event> = reader.by_ref().collect();
        let settings = in_force(&events);
        Ok(Self {
            path: reader.path().to_path_buf(),
            facts: reader.facts().clone(),
            settings,
            events,
            damage: reader.damage().to_vec(),
            metadata: reader.metadata().clone(),
        })
    }

    /// The ticks.
    pub fn records(&self) -> Vec<Record> {
        self.events.iter().filter_map(Event::record).collect()
    }
}

/// What a board works with: a scenario's settings are told before its motors are driven, and
/// the board's own, which it had at first, again when the scenario is over.
fn in_force(events: &[Event]) -> Option<Settings> {
    let is_driven = |event: &Event| {
        let record = event.record();
        record.is_some_and(|record| record.mode.drive().is_some())
    };
    let first = events.iter().position(is_driven).unwrap_or(events.len());
    let told = |event: &Event| match event.kind {
        EventKind::Received(_, ToHost::Settings(settings)) => Some(settings),
        EventKind::Received(..)
        | EventKind::Sent(..)
        | EventKind::Lost(..)
        | EventKind::Damaged(..)
        | EventKind::Disconnected => None,
    };
    let (before, after) = events.split_at(first);
    let in_force = before.iter().rev().find_map(told);
    // Somebody who came later hears of them later.
    in_force.or_else(|| after.iter().find_map(told))
}
