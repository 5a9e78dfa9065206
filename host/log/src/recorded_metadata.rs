//! Metadata as read from a log; [`metadata`](super::metadata) has the names.

use std::collections::BTreeMap;
use std::io;

use armbridge_link::message::Settings;
use mcap::records::{Record, op};

use super::limits::{METADATA_BYTES, METADATA_NAMES};
use super::mcap_records::{Next, Records, first_string, parse};
use super::metadata;
use crate::run_info::RunFacts;

/// Metadata by name and key.
pub(super) type MetadataByName = BTreeMap<String, BTreeMap<String, String>>;

/// Metadata of a file.
#[derive(Debug, Default)]
pub(super) struct RecordedMetadata {
    /// By name and key; for a repeated name, the last.
    pub(super) by_name: MetadataByName,
    /// Some is beyond the limits, and left out.
    pub(super) is_left_out: bool,
    /// Number of records with settings.
    settings_records: usize,
}

impl RecordedMetadata {
    /// Settings in force when the motors were first driven; `None` if the file has no record
    /// of them, or several.
    pub(super) fn settings(&self) -> Option<Settings> {
        let record = self.by_name.get(metadata::PARAMETERS)?;
        let is_alone = self.settings_records == 1;
        is_alone.then(|| serde_json::from_str(record.get("json")?).ok())?
    }

    /// Facts of the run with these settings.
    pub(super) fn facts(&self, settings: Option<&Settings>) -> RunFacts {
        let settings = settings.copied().unwrap_or_default();
        let run = self.by_name.get(metadata::RUN);
        run.and_then(|run| metadata::facts(run, &settings))
            .unwrap_or_else(|| RunFacts::from_settings("unknown", "unknown", &settings))
    }
}

/// All metadata of a file.
pub(super) fn read(records: &mut Records) -> io::Result<RecordedMetadata> {
    let (mut all, mut body) = (RecordedMetadata::default(), Vec::new());
    while let Next::Record(opcode) = records.next()? {
        if opcode != op::METADATA {
            continue;
        }
        if records.read(METADATA_BYTES, &mut body)?.is_err() {
            all.is_left_out = true;
            continue;
        }
        let is_known = first_string(&body).is_some_and(|name| all.by_name.contains_key(name));
        if !is_known && all.by_name.len() == METADATA_NAMES {
            all.is_left_out = true;
        } else if let Some(Record::Metadata(record)) = parse(opcode, &body) {
            all.settings_records += usize::from(record.name == metadata::PARAMETERS);
            all.by_name.insert(record.name, record.metadata);
        }
    }
    Ok(all)
}
