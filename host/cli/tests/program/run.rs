//! `armbridge run` as a user meets it: what it prints, what it leaves, how it ends.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// The program, in a folder of this test alone.
struct Program(PathBuf);

impl Program {
    fn new(test: &str) -> Self {
        Self(crate::folder(&format!("run-{test}")))
    }

    fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        let command = command.arg("run").args(args).current_dir(&self.0);
        command.env_remove("ARMBRIDGE_LINK").output().unwrap()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn a_scenario_leaves_a_log_plots_and_a_summary() {
    let program = Program::new("upright");
    let output = program.run(&["upright", "--duration", "8.5", "--verbose"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert!(
        printed.starts_with("armbridge upright · simulated: bench, nothing real moves · seed 1")
    );
    assert!(
        printed.contains("records written, 0 lost, 0 bytes unwritten"),
        "{printed}"
    );
    let folder = program.0.join(armbridge_tests::paths::run_folder(printed));
    for name in ["run.mcap", "angles.svg", "torque.png"] {
        assert!(folder.join(name).is_file(), "{name} in {folder:?}");
    }

    let again = program.run(&["upright", "--duration", "8.5", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(summary["segments"].as_array().unwrap().len(), 3);
    assert_eq!(summary["log"]["lost"], 0);
    let folder = program.0.join(summary["folder"].as_str().unwrap());
    assert!(folder.join("run.mcap").is_file() && summary["verdict"] == "done");
    // A record a millisecond, and the messages before and after.
    assert!(summary["log"]["written"].as_u64().unwrap() >= 8_500);
}

#[test]
fn a_push_has_a_recovery_of_its_own() {
    let program = Program::new("pushed");
    let output = program.run(&["push", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let pushes = summary["pushes"].as_array().unwrap();
    assert!(!pushes.is_empty(), "{summary}");
    for push in pushes {
        assert!(push["recovered_s"].as_f64().unwrap() < 3.0, "{push}");
        assert!(push["peak_error_mrad"].as_f64().unwrap() > 20.0, "{push}");
    }
    let start_s = pushes[0]["start_s"].as_f64().unwrap();
    for joint in summary["segments"][0]["joints"].as_array().unwrap() {
        let settled_s = joint["settling_time_s"].as_f64();
        assert!(
            settled_s.is_none_or(|settled_s| settled_s < start_s),
            "{joint}"
        );
    }
}

#[test]
fn what_was_expected_and_missed_is_exit_code_1() {
    let program = Program::new("missed");
    program.write(
        "mine.toml",
        "title = \"t\"\ncontrol = \"paper\"\n[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n\
         [stop]\nafter_s = 1\n[expect]\nsettles_within_s = 0.1\n",
    );
    let output = program.run(&["mine.toml"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let printed = text(&output.stdout).replace("\n   ", "");
    assert!(
        printed.contains("MISSED settling at a setpoint"),
        "{printed}"
    );
    // Where nothing is printed, the reason is one line.
    let output = program.run(&["mine.toml", "--quiet"]);
    let [printed, line] = [&output.stdout, &output.stderr].map(|bytes| text(bytes));
    assert_eq!((output.status.code(), printed), (Some(1), ""));
    assert!(
        line.starts_with("armbridge: the run failed: settling at a setpoint"),
        "{line}"
    );
    assert_eq!(line.lines().count(), 1, "{line}");
}

#[test]
fn torque_that_chatters_is_remarked_and_the_demo_has_no_remark() {
    let program = Program::new("chatter");
    let remarks = |args: &[&str]| {
        let output = program.run(args);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout).replace("\n    ", " ")
    };
    assert!(!remarks(&["demo"]).contains("at rest the torque"));
    let absurd = remarks(&[
        "demo",
        "--control",
        "paper",
        "--set",
        "controller.q=1e6,1e6,0,0",
    ]);
    assert!(
        absurd.contains("at rest the torque chatters: it changes by 0."),
        "{absurd}"
    );
    assert!(
        absurd.contains("limits hold the torque back in"),
        "{absurd}"
    );
}

#[test]
fn a_fault_ends_the_run_and_is_named() {
    let program = Program::new("fault");
    program.write(
        "mine.toml",
        "title = \"t\"\n[bench]\nfriction = false\n[[step]]\nat_s = 0\ntorque_nm = [0.7, 0]\n\
         [stop]\nafter_s = 5\n",
    );
    let output = program.run(&["mine.toml", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["faults"][0]["fault"], "angle_limit");
    let output = program.run(&["mine.toml", "--quiet"]);
    let line = text(&output.stderr);
    assert!(
        line.contains("the run failed: fault angle_limit at "),
        "{line}"
    );
}

#[test]
fn mistakes_are_one_line_and_nothing_is_left_behind() {
    let program = Program::new("mistakes");
    program.write("mine.toml", "title = \"t\"\n[stop]\nafter_s = \"soon\"\n");
    for (args, words) in [
        (["mine.toml", "--check"].as_slice(), "mine.toml:3:11: "),
        (&["mine.toml"], "mine.toml:3:11: "),
        (&["uprihgt"], "is it `upright`?"),
        (&["none.toml"], "cannot read none.toml"),
        (&["upright", "--link", "tcp://127.0.0.1:1"], "127.0.0.1:1"),
        (&["upright", "--link", "ftp:x"], "sim:"),
    ] {
        let output = program.run(args);
        let line = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {line}");
        assert_eq!(line.trim_end().lines().count(), 1, "{line}");
        assert!(line.contains(words), "{args:?}: no {words:?} in {line}");
    }
    let runs = fs::read_dir(program.0.join("runs")).map(Iterator::count);
    assert!(matches!(runs, Err(_) | Ok(0)), "{runs:?}");
}

#[test]
fn what_ships_is_listed_and_shown() {
    let program = Program::new("list");
    let list = program.run(&["--list"]);
    let listed = text(&list.stdout);
    let widest = listed.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(80), "{listed}");
    for name in ["upright", "paper-upright", "hour"] {
        assert!(
            listed.lines().any(|line| line.starts_with(name)),
            "{listed}"
        );
    }
    let shown = program.run(&["push", "--show"]);
    assert!(text(&shown.stdout).contains("[[bench.push]]"));
}

/// Control of a user's own is checked before anything moves.
#[test]
fn own_control_that_grows_is_refused_with_its_eigenvalue() {
    let program = Program::new("own-control");
    for (set, expected) in [
        (
            &[
                "estimator.kind=gain",
                "estimator.form=current",
                "estimator.gain=2.5,0,0.05,1",
            ][..],
            "the observer's error would grow: eigenvalue",
        ),
        (
            &["controller.integral=100,100"],
            "the closed loop would grow: eigenvalue",
        ),
        (
            &[
                "estimator.kind=luenberger",
                "estimator.poles_45ms=0.8±0.7i,0.1,0.1",
            ],
            "magnitude below 1",
        ),
        (&["controller.q=1e38,1,1,1"], "from 0 to 1000000"),
    ] {
        let mut args = vec!["upright", "--duration", "0.5"];
        args.extend(set.iter().flat_map(|pair| ["--set", pair]));
        let output = program.run(&args);
        assert_eq!(output.status.code(), Some(2), "{set:?}");
        let printed = text(&output.stderr);
        assert!(printed.contains(expected), "{set:?}: {printed}");
    }
}

/// Two points 10 ms apart, 0.3 rad from each other: what the arm would be asked for.
#[test]
fn a_stream_beyond_the_bounds_is_refused_by_its_point() {
    let program = Program::new("stream");
    let scenario = |first_s: f64| {
        format!(
            "title = \"t\"\n[bench]\ninitial_rad = [0.0, 0.0]\n[[step]]\nat_s = 0.0\n\
             regulate_rad = [0.0, 0.0]\n[[step]]\nat_s = 1.0\nstream = [\n\
             {{ after_s = {first_s}, angle_rad = [0.1, 0.0] }},\n\
             {{ after_s = 1.0, angle_rad = [0.1, 0.0] }},\n\
             {{ after_s = 1.01, angle_rad = [0.4, 0.0] }},\n]\n[stop]\nafter_s = 3.0\n"
        )
    };
    for (first_s, expected) in [
        (
            0.5,
            &[
                "joint 1 would reach",
                "rad/s²",
                "beyond the bound of 20.000 rad/s²",
            ][..],
        ),
        (0.01, &["after the step: give this point an `after_s` of"]),
    ] {
        program.write("s.toml", &scenario(first_s));
        let output = program.run(&["s.toml", "--check"]);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
        let printed = text(&output.stderr)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        for expected in expected {
            assert!(printed.contains(expected), "{printed}");
        }
    }
}
