//! Scenario files, motions and virtual arms as a user writes them: what is refused and
//! where, what is explained, and sweeps.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

/// The program, in a folder of this test alone.
struct Program(PathBuf);

impl Program {
    fn new(test: &str) -> Self {
        Self(crate::folder(&format!("scenarios-{test}")))
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        command.args(args).current_dir(&self.0);
        command.env_remove("ARMBRIDGE_LINK");
        command.env_remove("ARMBRIDGE_OUT");
        command
    }

    fn run(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Its standard output; it must succeed.
    fn prints(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(
            output.status.success(),
            "{args:?}: {}",
            text(&output.stderr)
        );
        text(&output.stdout).to_owned()
    }

    fn json(&self, args: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.prints(args)).unwrap()
    }

    /// One line on standard error with these words, and exit code 2.
    #[track_caller]
    fn refuses(&self, args: &[&str], words: &str) {
        let output = self.run(args);
        let line = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {line}");
        assert_eq!(line.trim_end().lines().count(), 1, "{args:?}: {line}");
        assert!(line.contains(words), "{args:?}: no {words:?} in {line}");
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

const HEAD: &str = "title = \"t\"\n[stop]\nafter_s = 5\n[[step]]\nat_s = 0\n";

#[test]
fn joint_values_are_two_and_a_scenario_has_a_step() {
    let program = Program::new("counts");
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
        program.refuses(&["run", "mine.toml", "--check"], &format!("mine.toml:{at}"));
    }
    program.write("mine.toml", "title = \"t\"\n[stop]\nafter_s = 5\n");
    program.refuses(&["run", "mine.toml", "--check"], "no `[[step]]`");
}

#[test]
fn an_option_is_not_blamed_on_the_file() {
    let program = Program::new("options");
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
        program.refuses(&["run", "upright", "--check", "--set", set], words);
    }
}

#[test]
fn a_scenario_is_read_from_standard_input() {
    let program = Program::new("stdin");
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
    assert!(text(&output.stdout).starts_with("- is in order"));
}

#[test]
fn a_run_takes_the_configured_control_or_says_that_it_does_not() {
    let program = Program::new("configured");
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
    let program = Program::new("period");
    // With some seeds the board discards samples before it knows the encoders' noise.
    for seed in ["1", "2", "4"] {
        let period = ["run", "upright", "--set", "setup.period_us=100000"];
        let args = [
            period.as_slice(),
            &["--duration", "1", "--json", "--seed", seed],
        ];
        let output = program.run(&args.concat());
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
    let program = Program::new("circle");
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
    let program = Program::new("motion");
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
        program.refuses(&["run", "mine.csv", "--check"], words);
    }
    program.write("mine.csv", &circle(10, 3.0));
    let words = "would need an acceleration of";
    program.refuses(&["run", "mine.csv", "--check"], words);
}

#[test]
fn keys_are_explained_from_the_table_that_checks_them() {
    let program = Program::new("explain");
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
    let program = Program::new("plants");
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
    program.refuses(&["run", "upright", "--plant", "heavi"], "is it `heavy`?");
}

#[test]
fn each_run_of_a_sweep_is_that_of_the_same_command() {
    let program = Program::new("sweep");
    let over = [
        "--over",
        "controller.r=[10,10],[20,20]",
        "--over",
        "seed=1..3",
    ];
    let args = [
        &["sweep", "push", "--duration", "2.9", "--json"],
        over.as_slice(),
    ]
    .concat();
    let sweep = program.json(&args);
    let runs = sweep["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 6);
    for (combination, seed) in [(0, 1), (1, 3)] {
        let value = ["controller.r=[10,10]", "controller.r=[20,20]"][combination];
        let seed_text = seed.to_string();
        let args = ["run", "push", "--duration", "2.9", "--json", "--set", value];
        let summary = program.json(&[args.as_slice(), &["--seed", &seed_text]].concat());
        let figures = &runs[3 * combination + seed - 1];
        assert_eq!(figures["seed"], seed);
        // The worse joint, equal to the bit.
        let worse = |values: [&serde_json::Value; 2]| {
            let [a, b] = values.map(|value| value.as_f64().unwrap().abs());
            a.max(b)
        };
        let torque = &summary["peak_torque_nm"];
        assert_eq!(figures["peak_torque_nm"], worse([&torque[0], &torque[1]]));
        let joints = &summary["segments"][0]["joints"];
        let error = [0, 1].map(|joint| &joints[joint]["steady_state_error_mrad"]);
        assert_eq!(figures["rest_error_mrad"], worse(error));
        let settled = [0, 1].map(|joint| &joints[joint]["settling_time_s"]);
        // The summary's is a difference of two times after the first record.
        let settled_s = figures["settling_time_s"].as_f64().unwrap();
        assert!((settled_s - worse(settled)).abs() < 1e-9);
    }
    assert_ne!(runs[0]["peak_torque_nm"], runs[3]["peak_torque_nm"]);
    let folder = program.0.join(sweep["folder"].as_str().unwrap());
    let csv = fs::read_to_string(folder.join("sweep.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7);
    assert!(
        csv.starts_with("controller.r,seed,settling_time_s,"),
        "{csv}"
    );
    for name in ["sweep.svg", "sweep.png"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    assert!(!folder.join("run.mcap").exists());
}

#[test]
fn every_combination_is_checked_before_anything_runs() {
    let program = Program::new("refused");
    for (over, words) in [
        (
            "controller.r=[10,10],[-1,1]",
            "with controller.r=[-1,1]: --set: `controller.r` cannot be",
        ),
        ("controller.r=10,20", "`controller.r` cannot be 10"),
        ("control=paper,papier", "`control` cannot be papier"),
        ("plant=default,haevy", "is it `heavy`?"),
        ("controler.r=1", "there is no parameter `controler.r`"),
        ("seed=9..1", "no range"),
        ("seed=1,1", "`seed` has the value 1 twice"),
        ("controller.r=[9,9],[9, 9]", "has the value [9, 9] twice"),
    ] {
        program.refuses(&["sweep", "upright", "--over", over], words);
    }
    let runs = fs::read_dir(program.0.join("runs")).map(Iterator::count);
    assert!(matches!(runs, Err(_) | Ok(0)), "{runs:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_runs_that_have_ended() {
    let program = Program::new("interrupted");
    let args = [
        "sweep",
        "push",
        "--duration",
        "2.9",
        "--over",
        "seed=1..20000",
        "--quiet",
        "--logs",
    ];
    let mut child = program
        .command(&args)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let logs = || {
        let folders = fs::read_dir(program.0.join("runs")).into_iter().flatten();
        let files = folders.flat_map(|folder| fs::read_dir(folder.unwrap().path()).unwrap());
        let paths = files.map(|file| file.unwrap().path());
        paths
            .filter(|path| path.extension().is_some_and(|it| it == "mcap"))
            .count()
    };
    // A processor has one log open at a time.
    let open = std::thread::available_parallelism().unwrap().get();
    while logs() < open + 3 {
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let pid = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    let folder = fs::read_dir(program.0.join("runs"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap();
    let csv = fs::read_to_string(folder.path().join("sweep.csv")).unwrap();
    assert!((2..20_000).contains(&csv.lines().count()), "{csv}");
    // Each log is that of a row.
    assert_eq!(logs(), csv.lines().count() - 1);
}

#[test]
fn a_run_that_misses_its_end_fails_alone_and_in_a_sweep() {
    let program = Program::new("missed-end");
    program.write(
        "late.toml",
        "title = \"t\"\n[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n[stop]\nafter_s = 0.6\n\
         angle_beyond_rad = [1, 1]\nsuccess = [\"angle\"]\n",
    );
    let missed = "the run lasts its whole time and does not end by angle";
    let output = program.run(&["run", "late.toml"]);
    let printed = text(&output.stdout).replace("\n   ", "");
    assert_eq!(output.status.code(), Some(1), "{printed}");
    assert!(printed.contains(missed), "{printed}");
    assert!(!printed.contains("not complete"), "{printed}");
    let output = program.run(&["sweep", "late.toml", "--over", "seed=1..2", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let sweep: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for run in sweep["runs"].as_array().unwrap() {
        assert_eq!(run["missed_expectations"][0], missed, "{run}");
    }
}

/// A run without plots, of two tick rates: the log of the second has no room.
#[cfg(target_os = "linux")]
#[test]
fn a_sweep_keeps_the_runs_before_a_log_that_cannot_be_written() {
    let program = Program::new("sweep-disk");
    program.write("armbridge.toml", "[record]\nplots = false\n");
    let script = format!(
        "trap '' XFSZ; ulimit -f 900; exec {} sweep upright --duration 4 --quiet --logs \
         --over setup.period_us=10000,1000",
        env!("CARGO_BIN_EXE_armbridge")
    );
    let mut command = Command::new("bash");
    command.args(["-c", &script]).current_dir(&program.0);
    let output = command.env_remove("ARMBRIDGE_OUT").output().unwrap();
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    for words in ["002-1.mcap", "ulimit -f", "after 1 of 2 runs"] {
        assert!(line.contains(words), "no {words:?} in {line}");
    }
    let mut folders = fs::read_dir(program.0.join("runs")).unwrap();
    let files = fs::read_dir(folders.next().unwrap().unwrap().path()).unwrap();
    let mut names: Vec<String> = files
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["001-1.mcap", "002-1.mcap", "sweep.csv"]);
}

#[test]
fn a_sweep_prints_the_remarks_on_its_scenario_once() {
    let program = Program::new("sweep-notes");
    program.write("armbridge.toml", "[controller]\nr = [12.0, 12.0]\n");
    let args = ["sweep", "push", "--duration", "0.5", "--over", "seed=1..2"];
    let output = program.run(&args);
    let notes = text(&output.stderr).matches("is not in force").count();
    assert_eq!(notes, 1, "{}", text(&output.stderr));
}

#[test]
fn a_check_is_json_on_request() {
    let program = Program::new("check-json");
    let report = program.json(&["run", "push", "--check", "--json", "--duration", "2.5"]);
    assert_eq!(report["scenario"], "push");
    assert_eq!(report["duration_s"], 2.5);
    assert!(report["title"].is_string() && report["notes"].is_array());
}

#[test]
fn pushes_without_setpoints_have_a_heading() {
    let program = Program::new("push-heading");
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
