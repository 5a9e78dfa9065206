//! `armbridge identify` as a user meets it, on logs of the bench.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// The program, in a folder of this test alone.
fn program(test: &str) -> impl Fn(&[&str]) -> Output {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("identify-{test}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    move |args| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        let command = command.args(args).current_dir(&folder);
        command.env_remove("ARMBRIDGE_LINK").output().unwrap()
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn the_benchs_arm_is_found_in_its_logs_and_a_board_takes_it() {
    let program = program("fit");
    let run = |scenario: &str| {
        let output = program(&["run", scenario]);
        let printed = text(&output.stdout);
        printed.lines().last().unwrap().to_owned()
    };
    let logs = [run("multisine"), run("sweep")];
    let fit = ["identify", "fit", &logs[0], &logs[1]];
    let output = program(&[&fit[..], &["--json", "--out", "arm.toml"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // What the bench's arm is, and the board believes it to be.
    for number in found["numbers"].as_array().unwrap() {
        let name = number["name"].as_str().unwrap();
        if name == "delay" || name.starts_with("dead zone") {
            continue;
        }
        let value = |key: &str| number[key].as_f64().unwrap();
        let off = (value("value") - value("before")).abs();
        // Four standard errors.
        assert!(off < 2.05 * value("within"), "{number}");
    }
    let output = program(&["set", "--from", "arm.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("the board has taken it"));
}

#[test]
fn logs_that_do_not_tell_are_told() {
    let program = program("poor");
    let output = program(&["run", "free-fall"]);
    let log = text(&output.stdout).lines().last().unwrap().to_owned();
    for (args, words) in [
        (["identify", "fit", &log], "too short a log"),
        (["identify", "fit", "none.mcap"], "no such file"),
    ] {
        let output = program(&args);
        let line = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(line.contains(words), "{line}");
        assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    }
}
