//! Recording: a log in memory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use armbridge_link::message::{Record, Settings};

pub use super::error::ReadError;
pub use super::reader::{Reader, Row, Rows};
use crate::run_info::RunFacts;
use armbridge_client::event::Event;

/// Contents of a log.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Path of the log.
    pub path: PathBuf,
    /// Facts of the run, with these settings.
    pub facts: RunFacts,
    /// Settings in force when the motors were first driven; else the last ones. None
    /// if the log has no settings.
    pub settings: Option<Settings>,
    /// All events, in order, including records.
    pub events: Vec<Event>,
    /// Damage of the file, each in one sentence; empty for an intact one.
    pub damage: Vec<String>,
    /// Metadata by name and key, such as `build`, `git`; see
    /// [`metadata`](super::metadata).
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
}

impl Recording {
    /// Reads a log up to its first damage; a folder means the log in it. An hour at 1 kHz
    /// takes gigabytes of memory; [`Reader`] needs some megabytes.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        let mut reader = Reader::open(path)?;
        let events: Vec<Event> = reader.by_ref().collect();
        Ok(Self {
            path: reader.path().to_path_buf(),
            facts: reader.facts().clone(),
            settings: reader.settings().copied(),
            events,
            damage: reader.damage().to_vec(),
            metadata: reader.metadata().clone(),
        })
    }

    /// Records of the ticks.
    pub fn records(&self) -> Vec<Record> {
        self.events.iter().filter_map(Event::record).collect()
    }
}
