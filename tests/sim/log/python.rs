//! Logs of the bench, read with the Python packages `mcap`, `mcap-protobuf-support` and
//! `foxglove-sdk`: see `tests/python/log.py`.

use std::path::{Path, PathBuf};

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_link::message::{Settings, Setup};
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_sim::link::{BoardUri, Options};
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::{Bench, link};
use armbridge_tests::kill::python;

use super::folder;

/// A run of 5 s on the bench, recorded.
fn recorded(name: &str) -> PathBuf {
    let path = folder(name).join("run.mcap");
    let facts = RunFacts::from_settings("test", "simulated: bench", &Settings::default());
    let recorder = Recorder::create_waiting(&path, &facts).unwrap();
    let mut options = Options::new(Bench::new(Plant::new(PlantConfig::default(), 1)));
    options.link.taps.push(recorder.tap());
    let runner = PlanRunner::new(Script::demo(Setup::default(), 5_000_000));
    let (_, done) = link::drive(&BoardUri::Sim, options, runner);
    done.map_err(|error| error.to_string()).unwrap();
    let report = recorder.finish().unwrap();
    assert!(report.records > 5_000 && report.lost == 0, "{report:?}");
    path
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_mcap_package_reads_every_topic() {
    let path = recorded("bench");
    let [read] = &python("all", &[&path])[..] else {
        panic!("not one line");
    };
    let count = |topic: &str| read["counts"][topic].as_u64().unwrap();
    assert!(count("/telemetry") > 5_000, "{read}");
    for topic in ["/joint_states", "/tf"] {
        assert!((250..300).contains(&count(topic)), "{read}");
    }
    assert_eq!(count("/simulation/state") + 1, count("/telemetry"));
    for topic in ["/commands", "/events", "/log", "/parameters", "/scene"] {
        assert!(count(topic) > 0, "{read}");
    }
    assert!((5..9).contains(&count("/statistics")), "{read}");
    assert_eq!(read["gaps"], 0);
    let kinds = read["kinds"].as_array().unwrap();
    for kind in ["hello", "arm", "regulate", "ack", "board", "mode", "idle"] {
        assert!(kinds.iter().any(|k| k == kind), "no {kind} in {kinds:?}");
    }
    let [numbers, unit] = read["l1_m"].as_array().unwrap().as_slice() else {
        panic!("no arm.l1_m: {read}");
    };
    assert!((numbers[0].as_f64().unwrap() - 0.095).abs() < 1e-6 && unit == "m");
    assert_eq!(
        read["frames"].to_string(),
        r#"[["link1","link2"],["link2","tip"],["table","link1"]]"#
    );
    for record in ["run", "build", "board", "parameters", "clock", "end"] {
        assert!(
            read["metadata"].get(record).is_some(),
            "no {record}: {read}"
        );
    }
    assert!(read["raw_bytes"].as_u64().unwrap() > 500_000, "{read}");
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn what_is_drawn_is_what_foxglove_itself_would_write() {
    let path = recorded("drawn");
    let read = python("sdk", &[&path]);
    assert!(read[0]["checked"].as_u64().unwrap() > 500, "{read:?}");
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_mcap_package_reads_what_is_left_of_a_log() {
    let path = recorded("whole");
    let whole = std::fs::read(&path).unwrap();
    let cuts: Vec<PathBuf> = (1..=20)
        .map(|twentieth| {
            let cut = path.with_file_name(format!("cut-{twentieth}.mcap"));
            // An odd number of bytes, in the middle of something.
            std::fs::write(&cut, &whole[..whole.len() * twentieth / 20 - 37]).unwrap();
            cut
        })
        .collect();
    let cuts: Vec<&Path> = cuts.iter().map(PathBuf::as_path).collect();
    let read = python("killed", &cuts);
    assert_eq!(read.len(), cuts.len());
    let ticks = |i: usize| read[i]["ticks"].as_u64().unwrap();
    for (i, cut) in cuts.iter().enumerate() {
        let ours = armbridge_log::recording::Recording::load(cut)
            .map_or(0, |recording| recording.records().len() as u64);
        assert_eq!(ticks(i), ours, "{}", cut.display());
    }
    assert!(ticks(19) > 5_000, "{read:?}");
}
