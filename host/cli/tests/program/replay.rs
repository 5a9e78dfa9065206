//! Replays of a part of a log, and of a log that another version wrote.

use std::fs;

use armbridge_log::recording::Reader;
use serde_json::Value;

use super::output::records;
use crate::program::Program;

#[test]
fn a_replay_begins_at_the_snapshot_before_a_time() {
    let program = Program::new("replay-from");
    program.prints(&["run", "demo", "--quiet"]);
    let replay = |from: &[&str]| -> Value {
        let arguments = [&["replay", "--json"], from].concat();
        serde_json::from_str(&program.prints(&arguments)).unwrap()
    };
    let whole = replay(&[]);
    assert_eq!(whole["verdict"], "equal");
    let last_s = whole["span_s"].as_f64().unwrap();
    for from_s in [2.5, last_s - 0.5] {
        let part = replay(&["--from", &from_s.to_string()]);
        assert_eq!(part["verdict"], "equal", "{part}");
        // The whole has ticks of bring-up before the first second, and none is left out.
        let records = part["records"].as_f64().unwrap();
        let expected = 1_000.0 * (last_s - from_s);
        assert!((expected..expected + 1_200.0).contains(&records), "{part}");
        assert_eq!(part["compared"], part["records"], "{part}");
    }
    program.refuses(
        &["replay", "--from", "0.01"],
        &["no snapshot before 0.01 s"],
    );
    program.refuses(&["replay", "--from", "-1"], &["0 or later"]);
}

#[test]
fn a_log_of_another_version_names_that_version() {
    let program = Program::new("replay-version");
    let log = records(&program).join("run.mcap");
    let mut bytes = fs::read(&log).unwrap();
    let reader = Reader::open(&log).unwrap();
    let schema = reader.metadata()["build"]["schema"].as_bytes();
    let places: Vec<_> = (bytes.windows(schema.len()).enumerate())
        .filter(|(_, window)| *window == schema)
        .map(|(at, _)| at)
        .collect();
    for at in places {
        bytes[at..at + schema.len()].fill(b'0');
    }
    fs::write(program.path("other.mcap"), bytes).unwrap();
    program.refuses(
        &["replay", "other.mcap"],
        &["was written by version", "with that version only"],
    );
    // Its ticks can still be read.
    assert!(
        program
            .prints(&["info", "other.mcap"])
            .contains("another version")
    );
}
