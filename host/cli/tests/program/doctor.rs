//! `armbridge doctor`: what is missing is named with its remedy, and fails what needs it.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// The command in this folder, on a machine without any program.
fn doctor(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.arg("doctor").args(args).current_dir(folder);
    let command = command.env("PATH", "").env_remove("CARGO_TARGET_DIR");
    command.env_remove("ARMBRIDGE_OUT").output().unwrap()
}

/// The row of a check in the output as JSON.
fn row(output: &Output, name: &str) -> Value {
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = report["checks"].as_array().unwrap();
    rows.iter()
        .find(|row| row["check"] == name)
        .unwrap()
        .clone()
}

#[test]
fn missing_programs_are_named_and_fail_only_what_needs_them() {
    let folder = tempfile::tempdir().unwrap();
    let output = doctor(folder.path(), &[]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    for words in [
        "QEMU            emulate     missing  not installed\n",
        "cargo install --locked probe-rs-tools",
        "no source tree of Armbridge here",
        "output folder   run         ok       runs can be written\n",
        "The simulated arm can run",
    ] {
        assert!(text.contains(words), "no {words:?} in:\n{text}");
    }
    let longest = text.lines().map(|line| line.chars().count()).max();
    assert!(longest <= Some(80), "{text}");

    let output = doctor(folder.path(), &["emulate"]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("QEMU is missing for emulate."), "{text}");
}

#[test]
fn rows_as_json_have_state_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let output = doctor(folder.path(), &["--json", "flash"]);
    assert_eq!(output.status.code(), Some(1));
    let rust = row(&output, "Rust target");
    assert_eq!(
        (&rust["state"], &rust["needed_for"]),
        (&"missing".into(), &"flash".into())
    );
    assert_eq!(rust["remedy"], "install Rust: https://rustup.rs");
    assert_eq!(row(&output, "terminal")["state"], "n/a");
    assert_eq!(row(&output, "output folder")["remedy"], Value::Null);
    // Tests are built with every part.
    for (name, job) in [
        ("Parquet files", "parquet"),
        ("viewer server", "foxglove"),
        ("board log lines", "defmt"),
    ] {
        let part = row(&output, name);
        assert_eq!(
            (&part["state"], &part["needed_for"]),
            (&"ok".into(), &job.into())
        );
    }
}

#[test]
fn an_image_older_than_its_sources_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let (inside, source) = crate::emulator::tree(folder.path());
    let image = || row(&doctor(&inside, &["--json"]), "firmware image");
    assert_eq!(image()["state"], "ok");
    std::fs::remove_file(source).unwrap();
    let image = image();
    assert_eq!(image["state"], "stale");
    assert_eq!(image["finding"], "older than firmware/src/main.rs");
    assert_eq!(image["remedy"], "cargo build-emulator");
}

/// Without a folder for its files there is no run.
#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_cannot_be_written_fails() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.arg("doctor").current_dir(folder.path());
    let output = command.env("ARMBRIDGE_OUT", "/proc/runs").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("/proc/runs cannot be written"), "{text}");
}
