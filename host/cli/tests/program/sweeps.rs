//! Sweeps as a user meets them: each run, what is refused, and what is kept of an early end.

use std::fs;
use std::process::{Command, Stdio};

use crate::program::{Program, text};

#[test]
fn each_run_of_a_sweep_is_that_of_the_same_command() {
    let program = Program::new("scenarios-sweep");
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
    let program = Program::new("scenarios-refused");
    for (over, words) in [
        (
            "controller.r=[10,10],[-1,1]",
            "with controller.r=[-1,1]: --set: `controller.r` cannot be",
        ),
        (
            "controller.r=10,20",
            "`controller.r` takes lists: write each value in brackets",
        ),
        ("control=paper,papier", "`control` cannot be papier"),
        ("plant=default,haevy", "is it `heavy`?"),
        ("controler.r=1", "there is no parameter `controler.r`"),
        ("seed=9..1", "no range"),
        ("seed=1,1", "`seed` has the value 1 twice"),
        ("controller.r=[9,9],[9, 9]", "has the value [9, 9] twice"),
    ] {
        program.refuses(&["sweep", "upright", "--over", over], &[words]);
    }
    let runs = fs::read_dir(program.0.join("runs")).map(Iterator::count);
    assert!(matches!(runs, Err(_) | Ok(0)), "{runs:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_runs_that_have_ended() {
    let program = Program::new("scenarios-interrupted");
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
    let program = Program::new("scenarios-missed-end");
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
    let program = Program::new("scenarios-sweep-disk");
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
    let program = Program::new("scenarios-sweep-notes");
    program.write("armbridge.toml", "[controller]\nr = [12.0, 12.0]\n");
    let args = ["sweep", "push", "--duration", "0.5", "--over", "seed=1..2"];
    let output = program.run(&args);
    let notes = text(&output.stderr).matches("is not in force").count();
    assert_eq!(notes, 1, "{}", text(&output.stderr));
}
