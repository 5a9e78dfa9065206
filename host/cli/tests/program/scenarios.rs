//! Scenario files, motions and virtual arms as a user writes them: what is refused and
//! where, and what is explained.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::Stdio;

use crate::program::{Program, text};

const HEAD: &str = "title = \"t\"\n[stop]\nafter_s = 5\n[[step]]\nat_s = 0\n";

#[test]
fn joint_values_are_two_and_a_scenario_has_a_step() {
    let program = Program::new("scenarios-counts");
    for (tail, at) in [
        (
            "regulate_rad = [0, 0, 0.7]\n",
            "6:16: `regulate_rad` takes 2 numbers",
        ),
        (
            "torque_nm = [0, 0, 0]\n",
            "6:13: `torque_nm` takes 2 numbers",
        ),
        (
            "minimum_jerk = { to_rad = [0.1, 0, 9] }\n",
            "6:27: `to_rad` takes 2 numbers",
        ),
        (
            "stream = [{ after_s = 1, angle_rad = [0, 0, 0] }]\n",
            "6:38: `angle_rad` takes 2 numbers",
        ),
        (
            "regulate_rad = [0, 0]\n[bench]\ninitial_rad = [0, 0, 0]\n",
            "8:15: `initial_rad` takes 2 numbers",
        ),
        (
            "regulate_rad = [0, 0]\n[bench]\nplant.joint1.stops_rad = [-1, 1, 2]\n",
            "8:26: `stops_rad` takes 2 numbers",
        ),
    ] {
        program.write("mine.toml", &format!("{HEAD}{tail}"));
        program.refuses(
            &["run", "mine.toml", "--check"],
            &[&format!("mine.toml:{at}")],
        );
    }
    program.write("mine.toml", "title = \"t\"\n[stop]\nafter_s = 5\n");
    program.refuses(&["run", "mine.toml", "--check"], &["no `[[step]]`"]);
}

#[test]
fn an_option_is_not_blamed_on_the_file() {
    let program = Program::new("scenarios-options");
    for (set, words) in [
        (
            "controller.Q=1",
            "--set: there is no parameter `controller.Q`; is it `controller.q`?",
        ),
        (
            "limits.hold_ms=600",
            "--set: `limits.hold_ms` (600) is longer",
        ),
    ] {
        program.refuses(&["run", "upright", "--check", "--set", set], &[words]);
    }
}

#[test]
fn a_scenario_is_read_from_standard_input() {
    let program = Program::new("scenarios-stdin");
    let mut child = program
        .command(&["run", "-", "--check"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let shown = program.prints(&["run", "upright", "--show"]);
    child
        .stdin
        .take()
        .unwrap()
        .write_all(shown.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(text(&output.stdout).starts_with("stdin is in order"));
}

#[test]
fn a_run_takes_the_configured_control_or_says_that_it_does_not() {
    let program = Program::new("scenarios-configured");
    program.write("armbridge.toml", "[controller]\nq = [40, 40, 0.5, 0.5]\n");
    program.write("mine.toml", &format!("{HEAD}regulate_rad = [0, 0]\n"));
    let run = |args: &[&str]| {
        let args = [&["run", "mine.toml", "--duration", "1", "--json"], args].concat();
        let output = program.run(&args);
        assert!(
            output.status.code().is_some_and(|code| code < 2),
            "{output:?}"
        );
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let setup = summary["run"]["setup"]["controller"].to_string();
        (setup, text(&output.stderr).to_owned())
    };
    let (setup, note) = run(&[]);
    assert!(
        setup.contains("40.0") && !note.contains("not in force"),
        "{setup} {note}"
    );
    let (setup, note) = run(&["--control", "compensated"]);
    assert!(!setup.contains("40.0"), "{setup}");
    assert!(
        note.contains("`controller.q` in armbridge.toml is not in force"),
        "{note}"
    );
    let told = program.prints(&["config"]);
    assert!(told.contains("control is the board's own take"), "{told}");
}

#[test]
fn the_longest_period_arms() {
    let program = Program::new("scenarios-period");
    // With some seeds the board discards samples before it knows the encoders' noise.
    for seed in ["1", "2", "4"] {
        let period = ["run", "upright", "--set", "setup.period_us=100000"];
        let args = [
            period.as_slice(),
            &["--duration", "1", "--json", "--seed", seed],
        ];
        // At this period the motors cannot be checked, which the user has to confirm.
        let refused = program.run(&args.concat());
        assert!(text(&refused.stderr).contains("--set limits.check_rad_s2=0"));
        let confirmed = [args[0], args[1], &["--set", "limits.check_rad_s2=0"]];
        let output = program.run(&confirmed.concat());
        let line = text(&output.stderr);
        assert!(
            output.status.code().is_some_and(|code| code < 2),
            "{seed}: {line}"
        );
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(summary["ticks"].as_u64().unwrap() > 5, "{summary}");
    }
}

/// A circle of 0.2 rad about (0.1, 0.0) rad in 4 s, once around, with a header and `step_ms`.
fn circle(step_ms: u32, turns_per_s: f64) -> String {
    let mut csv = String::from("t_ms,q1_rad,q2_rad\n");
    for ms in (0..=4_000).step_by(step_ms as usize) {
        let angle = std::f64::consts::TAU * turns_per_s * f64::from(ms) * 1e-3;
        let (sin, cos) = angle.sin_cos();
        writeln!(csv, "{ms},{:.4},{:.4}", 0.1 + 0.2 * cos, 0.2 * sin).unwrap();
    }
    csv
}

#[test]
fn a_circle_from_a_csv_runs_well_at_any_spacing() {
    let program = Program::new("scenarios-circle");
    for step_ms in [1, 10, 100] {
        program.write("circle.csv", &circle(step_ms, 0.25));
        let checked = program.prints(&["run", "circle.csv", "--check"]);
        assert!(checked.contains("of 20 rad/s²"), "{checked}");
        assert!(
            checked.lines().all(|line| line.chars().count() <= 80),
            "{checked}"
        );
        let summary = program.json(&["run", "circle.csv", "--json"]);
        for joint in 0..2 {
            let rms_mrad = summary["tracking_rms_mrad"][joint].as_f64().unwrap();
            let torque_nm = summary["peak_torque_nm"][joint].as_f64().unwrap();
            assert!(rms_mrad < 10.0, "{step_ms} ms: {rms_mrad} mrad");
            assert!(torque_nm < 1.0, "{step_ms} ms: {torque_nm} N m");
        }
        assert_eq!(summary["faults"].as_array().unwrap().len(), 0);
    }
}

#[test]
fn a_motion_that_the_board_does_not_allow_names_its_line() {
    let program = Program::new("scenarios-motion");
    for (text, words) in [
        (
            "time,q1_rad,q2_rad\n0,0,0\n",
            "mine.csv:1:1: there is no column `time`; accepted",
        ),
        (
            "t_s,q1_rad,q2_rad\n0,0,0\n1,x,0\n",
            "mine.csv:3:3: `x` is no number",
        ),
        (
            "t_s,q1_rad,q2_rad\n0,0,0\n0,0,0\n",
            "mine.csv:3:1: times grow",
        ),
        (
            "t_s,q1_deg,q2_rad\n0,0,0\n1,80,0\n",
            "mine.csv:3:3: joint 1 would be at 1.3963 rad",
        ),
        // Up and down within 0.2 s.
        (
            "t_s,q1_rad,q2_rad\n0,0,0\n1,0,0\n1.1,0.2,0\n1.2,0,0\n2,0,0\n",
            "mine.csv:4:1: joint 1 would need an acceleration of",
        ),
    ] {
        program.write("mine.csv", text);
        program.refuses(&["run", "mine.csv", "--check"], &[words]);
    }
    program.write("mine.csv", &circle(10, 3.0));
    let words = "would need an acceleration of";
    program.refuses(&["run", "mine.csv", "--check"], &[words]);
}

#[test]
fn keys_are_explained_from_the_table_that_checks_them() {
    let program = Program::new("scenarios-explain");
    let keys = program.prints(&["run", "--explain"]);
    for words in [
        "step.regulate_rad: 2 numbers from -1.2 to 1.2 rad",
        "[[bench.push]]",
        "expect.tracks_within_rad",
    ] {
        assert!(keys.contains(words), "no {words:?} in {keys}");
    }
    let plant = program.prints(&["plants", "--explain"]);
    assert!(
        plant.contains("joint2.coulomb_nm: a number from 0 to 10 N m; default 0.04"),
        "{plant}"
    );
    for text in [&keys, &plant] {
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
    }
}

#[test]
fn virtual_arms_have_names() {
    let program = Program::new("scenarios-plants");
    let list = program.prints(&["plants"]);
    assert!(
        list.lines().any(|line| line.starts_with("heavy ")),
        "{list}"
    );
    assert!(
        program
            .prints(&["plants", "heavy"])
            .contains("inertia_scale = 1.2")
    );
    let torque = |plant: &str| {
        let args = [
            "run",
            "push",
            "--duration",
            "2.9",
            "--json",
            "--plant",
            plant,
        ];
        program.json(&args)["peak_torque_nm"].to_string()
    };
    program.write("mine.toml", "inertia_scale = 1.2\ngravity_scale = 1.2\n");
    assert_eq!(torque("heavy"), torque("mine.toml"));
    assert_ne!(torque("heavy"), torque("default"));
    program.refuses(&["run", "upright", "--plant", "heavi"], &["is it `heavy`?"]);
}

#[test]
fn a_check_is_json_on_request() {
    let program = Program::new("scenarios-check-json");
    let report = program.json(&["run", "push", "--check", "--json", "--duration", "2.5"]);
    assert_eq!(report["scenario"], "push");
    assert_eq!(report["duration_s"], 2.5);
    assert!(report["title"].is_string() && report["notes"].is_array());
}

#[test]
fn pushes_without_setpoints_have_a_heading() {
    let program = Program::new("scenarios-push-heading");
    program.write(
        "pushed.toml",
        "title = \"t\"\n[bench]\ninitial_rad = [0, 0]\n[[bench.push]]\nat_s = 0.1\njoint = 1\n\
         torque_nm = 0.01\nduration_s = 0.05\n[[step]]\nat_s = 0\ntorque_nm = [0, 0]\n\
         [stop]\nafter_s = 0.5\n",
    );
    let printed = text(&program.run(&["run", "pushed.toml"]).stdout).to_owned();
    let lines: Vec<&str> = printed.lines().collect();
    let push = lines.iter().position(|line| line.contains("push, joint 1"));
    let heading = lines[push.expect(&printed) - 1];
    assert!(heading.contains("within 20 mrad after"), "{printed}");
}

#[test]
fn a_joint_that_does_not_rest_has_no_error_at_rest() {
    let program = Program::new("not-at-rest");
    let output = program.run(&["run", "upright", "--duration", "0.64"]);
    let printed = text(&output.stdout);
    assert!(
        printed.contains("never   never               –     – mrad"),
        "{printed}"
    );
}

#[test]
fn logs_of_different_periods_are_not_called_different_arms() {
    let program = Program::new("fit-of-two-periods");
    for (folder, period_us) in [("one", "1000"), ("two", "2000")] {
        let set = format!("setup.period_us={period_us}");
        let args = [
            "run",
            "multisine",
            "--duration",
            "2",
            "--out",
            folder,
            "--set",
            &set,
        ];
        assert!(program.run(&args).status.code().is_some());
    }
    let log = |folder: &str| {
        let run = std::fs::read_dir(program.path(folder)).unwrap().next();
        run.unwrap().unwrap().path().join("run.mcap")
    };
    let [one, two] = ["one", "two"].map(|folder| log(folder).display().to_string());
    let words = ["have different periods, 1000 and 2000 µs; fit them one by one"];
    program.refuses(&["identify", "fit", &one, &two], &words);
}

#[test]
fn a_scenario_that_is_too_long_is_refused_before_it_is_parsed() {
    let program = Program::new("scenarios-long");
    let step = "[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n";
    program.write("long.toml", &(HEAD.to_owned() + &step.repeat(120_000)));
    program.refuses(
        &["run", "long.toml", "--check"],
        &["long.toml is longer than 4 MiB", "every_s"],
    );
}
