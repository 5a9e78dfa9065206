//! Metadata as read from a log; [`metadata`](super::metadata) has the names.

use std::collections::BTreeMap;
use std::io;

use armbridge_shared::link::message::Settings;
use mcap::records::{Record, op};

use super::limits::{METADATA_BYTES, METADATA_NAMES};
use super::metadata;
use super::records::{Next, Records, first_string, parse};
use crate::run_info::RunFacts;

/// Metadata by name and key.
pub(super) type MetadataByName = BTreeMap<String, BTreeMap<String, String>>;

/// Last settings of the board; `None` if there are none.
pub(super) fn settings(metadata_by_name: &MetadataByName) -> Option<Settings> {
    serde_json::from_str(metadata_by_name.get(metadata::PARAMETERS)?.get("json")?).ok()
}

/// Facts of the run; derived from its settings, if it has none.
pub(super) fn facts(metadata_by_name: &MetadataByName) -> RunFacts {
    let recorded = metadata_by_name
        .get(metadata::RUN)
        .and_then(metadata::facts);
    recorded.unwrap_or_else(|| {
        RunFacts::from_settings(
            "unknown",
            "unknown",
            &settings(metadata_by_name).unwrap_or_default(),
        )
    })
}

/// All metadata of a file, and whether some is beyond the limits and left out; for a repeated
/// name, the last.
pub(super) fn read(records: &mut Records) -> io::Result<(MetadataByName, bool)> {
    let (mut all, mut body) = (MetadataByName::new(), Vec::new());
    let mut is_left_out = false;
    while let Next::Record(opcode) = records.next()? {
        if opcode != op::METADATA {
            continue;
        }
        if records.read(METADATA_BYTES, &mut body)?.is_err() {
            is_left_out = true;
            continue;
        }
        let is_known = first_string(&body).is_some_and(|name| all.contains_key(name));
        if !is_known && all.len() == METADATA_NAMES {
            is_left_out = true;
        } else if let Some(Record::Metadata(record)) = parse(opcode, &body) {
            all.insert(record.name, record.metadata);
        }
    }
    Ok((all, is_left_out))
}
