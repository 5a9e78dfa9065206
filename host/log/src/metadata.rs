//! Metadata of a log: records of names and values, as text.
//!
//! | record       | contents                                                      |
//! |--------------|---------------------------------------------------------------|
//! | `run`        | facts of the run that no setting changes, by their names and as `json` |
//! | `build`      | of this program: `git`, `version`, `schema`                   |
//! | `board`      | of the board: `image` (CRC-32 of its program), `session`, `json` |
//! | `parameters` | settings in force when the motors were first driven, by their names and as `json`; those at the end if they never were |
//! | `clock`      | the two clocks: `offset_ns`, `at_board_us`, `drift_ppm`, `residual_us`, `residual_most_us` |
//! | `end`        | `ticks`, `missing_ticks`, `unwritten_bytes`; only of a log that was closed |
//!
//! Each is written once, `board` again after a reset. Later changes of settings are messages of
//! `/parameters`.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use armbridge_client::params;
use armbridge_link::message::{BoardReport, Settings};
use armbridge_link::schema;
use armbridge_servo::JOINTS;
use mcap::records::Metadata;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::clock_sync::Line;
use crate::run_info::RunFacts;

/// Name of the record with the facts of the run.
pub(crate) const RUN: &str = "run";
/// Name of the record about this program.
pub(crate) const BUILD: &str = "build";
/// Name of the record about the board.
pub const BOARD: &str = "board";
/// Name of the record with the settings.
pub(crate) const PARAMETERS: &str = "parameters";
/// Name of the record about the clocks.
const CLOCK: &str = "clock";
/// Name of the record that a log ends with.
pub const END: &str = "end";

/// The commit that the program was built from, once it is set.
static COMMIT: OnceLock<&'static str> = OnceLock::new();

/// Sets the commit that the program was built from, for all later logs. Without it
/// the commit is `unknown`.
pub fn set_commit(commit: &'static str) {
    // Only the first call counts: a program does not change while it runs.
    let _ = COMMIT.set(commit);
}

/// Hash of the link's schema, as text.
pub(crate) fn schema_hash() -> String {
    format!("{:016x}", u64::from_be_bytes(schema::HASH))
}

fn record<const N: usize>(name: &str, pairs: [(&str, String); N]) -> Metadata {
    Metadata {
        name: name.into(),
        metadata: pairs.map(|(key, value)| (key.to_owned(), value)).into(),
    }
}

/// Facts of a run that no setting changes.
#[derive(Serialize, Deserialize)]
struct RunRecord {
    name: String,
    world: String,
    version: String,
    seed: Option<u64>,
    static_friction_nm: Option<[f64; JOINTS]>,
}

pub(super) fn run(facts: &RunFacts) -> Metadata {
    let record = RunRecord {
        name: facts.name.clone(),
        world: facts.world.clone(),
        version: facts.version.clone(),
        seed: facts.seed,
        static_friction_nm: facts.static_friction_nm,
    };
    let mut metadata = fields(&record);
    metadata.insert("json".into(), json(&record));
    Metadata {
        name: RUN.into(),
        metadata,
    }
}

pub(super) fn build() -> Metadata {
    record(
        BUILD,
        [
            ("git", (*COMMIT.get().unwrap_or(&"unknown")).into()),
            ("version", env!("CARGO_PKG_VERSION").into()),
            ("schema", schema_hash()),
        ],
    )
}

pub(super) fn board(report: &BoardReport) -> Metadata {
    let image = report
        .image
        .map_or_else(|| "none".to_owned(), |crc| format!("{crc:08x}"));
    record(
        BOARD,
        [
            ("image", image),
            ("session", format!("{:#x}", report.session)),
            ("json", json(report)),
        ],
    )
}

pub(super) fn parameters(settings: &Settings) -> Metadata {
    let mut metadata: BTreeMap<_, _> = params::pairs(settings)
        .into_iter()
        .map(|(parameter, value)| (parameter.key.to_owned(), params::to_text(&value)))
        .collect();
    metadata.insert("json".into(), json(settings));
    Metadata {
        name: PARAMETERS.into(),
        metadata,
    }
}

pub(super) fn clock(line: &Line) -> Metadata {
    record(
        CLOCK,
        [
            ("offset_ns", line.offset_ns.to_string()),
            ("at_board_us", line.at_board_us.to_string()),
            ("drift_ppm", format!("{:.4}", line.drift_ppm)),
            ("residual_us", format!("{:.3}", line.residual_us)),
            ("residual_most_us", format!("{:.3}", line.residual_most_us)),
        ],
    )
}

pub(super) fn end((ticks, missing): (u64, u64), unwritten: u64) -> Metadata {
    record(
        END,
        [
            ("ticks", ticks.to_string()),
            ("missing_ticks", missing.to_string()),
            ("unwritten_bytes", unwritten.to_string()),
        ],
    )
}

/// The facts of a run with these settings, from its record.
pub(super) fn facts(run: &BTreeMap<String, String>, settings: &Settings) -> Option<RunFacts> {
    let record: RunRecord = serde_json::from_str(run.get("json")?).ok()?;
    let facts = RunFacts {
        version: record.version,
        seed: record.seed,
        static_friction_nm: record.static_friction_nm,
        ..RunFacts::from_settings(&record.name, &record.world, settings)
    };
    Some(facts.with_settings(settings))
}

/// JSON of plain data, which cannot fail.
fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// Each field of a value as text.
fn fields(value: &impl Serialize) -> BTreeMap<String, String> {
    let Ok(Value::Object(fields)) = serde_json::to_value(value) else {
        return BTreeMap::new();
    };
    fields
        .into_iter()
        .map(|(key, value)| match value {
            Value::String(text) => (key, text),
            other => (key, other.to_string()),
        })
        .collect()
}
