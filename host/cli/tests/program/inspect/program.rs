//! Output, files and exit codes of the program.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use armbridge_link::message::{Controller, Gains, Setup};
use armbridge_tests::paths::run_folder;
use serde_json::Value;

use super::bench::{Run, record};
use super::folder;

pub(super) fn armbridge(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    command.args(args).current_dir(folder).output().unwrap()
}

/// Its standard output; it must end with this code.
pub(super) fn printed(folder: &Path, args: &[&str], code: i32) -> String {
    let output = armbridge(folder, args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

pub(super) fn json(folder: &Path, args: &[&str], code: i32) -> Value {
    serde_json::from_str(&printed(folder, args, code)).unwrap()
}

#[test]
fn the_settings_that_ran_are_those_of_the_log() {
    let folder = folder("in_force");
    let scenario = "title = \"t\"\ncontrol = \"paper\"\n[[step]]\nat_s = 0\n\
                    regulate_rad = [0, 0]\n[stop]\nafter_s = 1\n";
    fs::write(folder.join("mine.toml"), scenario).unwrap();
    let run = ["run", "mine.toml", "--set", "setup.period_us=2000"];
    printed(&folder, &run, 0);
    let info = json(&folder, &["info", "--json"], 0);
    assert_eq!(info["run"]["period_us"], 2000);
    let text = printed(&folder, &["info"], 0);
    assert!(text.contains("period 2000 µs"), "{text}");
    let settings = info["settings"].as_array().unwrap();
    let period = settings.iter().find(|s| s["key"] == "setup.period_us");
    assert_eq!(period.unwrap()["values"][1], 2000);
    // The simulation's truth is in the log, and in its table.
    let ticks = info["ticks"].as_u64().unwrap();
    assert_eq!(info["topics"]["/simulation/state"], ticks - 1);
    printed(&folder, &["export", "csv", "--out", "run.csv"], 0);
    let csv = fs::read_to_string(folder.join("run.csv")).unwrap();
    assert!(csv.lines().next().unwrap().contains("true_angle_rad_1"));
    assert!(!csv.lines().last().unwrap().ends_with(','), "{csv}");
}

#[test]
fn a_log_is_told_drawn_and_exported() {
    let folder = folder("whole");
    let run = folder.join("runs/2026-01-01T00-00-00Z-test");
    fs::create_dir_all(&run).unwrap();
    record(&run, Run::default());

    // Without a name, the newest run.
    let text = printed(&folder, &["info"], 0);
    for words in [
        "nothing: the log is whole",
        "test · simulated: bench · seed 1 · period 1000 µs",
        "gaps        none",
        "faults      none",
        "regulate 3",
        "controller.q",
        "/telemetry",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
    let info = json(&folder, &["info", "--json"], 0);
    let ticks = info["ticks"].as_u64().unwrap();
    assert!((2000..2300).contains(&ticks), "{ticks}");
    assert_eq!(info["missing_ticks"], 0);
    assert_eq!(info["commands"]["regulate"], serde_json::json!([3, 0]));
    assert_eq!(info["topics"]["/telemetry"], ticks);
    assert_eq!(info["messages"]["record"], ticks);

    printed(&folder, &["export", "csv"], 0);
    let csv = fs::read_to_string(run.join("run.csv")).unwrap();
    assert_eq!(csv.lines().count() as u64, ticks + 1);
    assert!(csv.starts_with("time_s,tick,board_mode,"));

    let plots = printed(&folder, &["plot", "--format", "svg", "--out", "plots"], 0);
    assert_eq!(plots.lines().count(), 7, "{plots}");
    let args = [
        "plot",
        "--what",
        "phase,spectrum",
        "--from",
        "1",
        "--to",
        "1.5",
    ];
    let plots = printed(&folder, &args, 0);
    let names: Vec<&str> = plots.lines().filter_map(|l| l.rsplit('/').next()).collect();
    assert_eq!(
        names,
        ["phase.svg", "phase.png", "spectrum.svg", "spectrum.png"]
    );
    for (args, words) in [
        (["plot", "--from", "7"].as_slice(), "nothing lies between"),
        (&["info", "nowhere"], "no such file"),
        (&["export", "mat", "--out", "nowhere/x.mat"], "--out"),
    ] {
        let output = armbridge(&folder, args);
        let line = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(line.contains(words) && line.lines().count() == 1, "{line}");
    }
}

#[test]
fn what_is_missing_is_told_and_not_filled_in() {
    let folder = folder("gap");
    let run = Run {
        push_nm: Some(3.0),
        deaf: [700, 720],
        ..Run::default()
    };
    record(&folder, run);
    // The file breaks off as well.
    let path = folder.join("run.mcap");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 5_000]).unwrap();

    let info = json(&folder, &["info", "run.mcap", "--json"], 0);
    assert_eq!(info["gap_count"], 1, "{info}");
    let missing = info["gaps"][0]["ticks"].as_u64().unwrap();
    assert_eq!(info["missing_ticks"], missing);
    assert!((15..=20).contains(&missing), "{info}");
    assert!(!info["damage"].as_array().unwrap().is_empty());
    let fault = &info["faults"][0];
    assert!(fault["cause"]["value"].is_number(), "{fault}");
    let text = printed(&folder, &["info", "run.mcap"], 0);
    let name = fault["fault"].as_str().unwrap();
    for words in [name, "lost on the link or in the log", "tick "] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }

    printed(&folder, &["export", "csv", "run.mcap"], 0);
    let csv = fs::read_to_string(folder.join("run.csv")).unwrap();
    let rows = csv.lines().skip(1);
    let ticks: Vec<u64> = rows
        .map(|row| row.split(',').nth(1).unwrap().parse().unwrap())
        .collect();
    let jumps: Vec<u64> = ticks.windows(2).map(|two| two[1] - two[0] - 1).collect();
    assert_eq!(jumps.iter().sum::<u64>(), missing);

    let args = ["plot", "run.mcap", "--format", "svg", "--what", "angles"];
    printed(&folder, &args, 0);
    let svg = fs::read_to_string(folder.join("angles.svg")).unwrap();
    assert!(svg.contains("no records") && svg.contains(&format!("fault: {name}")));
}

#[test]
fn the_same_seed_is_the_same_and_another_is_not() {
    let folder = folder("diff");
    let stiff = Setup {
        controller: Controller::StateFeedback(Gains::Design {
            q: [60.0, 60.0, 0.3, 0.3],
            r: [10.0, 10.0],
        }),
        ..Setup::best()
    };
    let runs = [
        ("a", Run::default()),
        ("again", Run::default()),
        (
            "seed",
            Run {
                seed: 2,
                ..Run::default()
            },
        ),
        (
            "stiff",
            Run {
                setup: stiff,
                ..Run::default()
            },
        ),
    ];
    for (name, run) in runs {
        fs::create_dir_all(folder.join(name)).unwrap();
        record(&folder.join(name), run);
    }
    let same = printed(&folder, &["diff", "a", "again"], 0);
    assert!(same.ends_with("The same.\n"), "{same}");

    let seeds = json(&folder, &["diff", "a", "seed", "--json"], 1);
    assert_eq!(seeds["settings"], serde_json::json!([]));
    let other = &seeds["runs"][0];
    assert!(other["first_command"].is_null());
    // The check of the motors ends within a tick of the other's.
    let unmatched: Vec<u64> = serde_json::from_value(other["unmatched"].clone()).unwrap();
    assert!(unmatched.iter().all(|count| *count <= 1), "{unmatched:?}");
    let [max, rms] = difference(other, "angle_rad_1");
    assert!(0.0 < rms && rms < max && max < 0.05, "{other}");

    let text = printed(&folder, &["diff", "a", "stiff", "again"], 1);
    for words in [
        "settings   1 differ",
        "  controller.q\n    A  [30.0, ",
        "    B  [60.0, ",
        "number 2 is the first that differs:\n  configure sets other values of controller.q\n",
        "B against A",
        "torque_nm_1",
        "C against A",
        "outputs    the same in every tick",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
    let args = ["plot", "a", "seed", "stiff", "--out", "three"];
    let plots = printed(&folder, &args, 0);
    let names: Vec<&str> = plots.lines().filter_map(|l| l.rsplit('/').next()).collect();
    let expected = [
        "angles",
        "tracking",
        "torque",
        "path",
        "phase",
        "spectrum",
        "difference",
    ];
    let expected: Vec<String> = expected
        .iter()
        .flat_map(|name| ["svg", "png"].map(|ending| format!("compare-{name}.{ending}")))
        .collect();
    assert_eq!(names, expected);
    let svg = fs::read_to_string(folder.join("three/compare-difference.svg")).unwrap();
    for words in [
        "3 runs",
        "test · simulated: bench · period 1000 µs<",
        ">control compensated · seed 1<",
        ">control compensated · seed 2<",
        ">seed 1 · controller.q 60.0, 60.0, 0.3, 0.3<",
        "minus the first: rms ",
        "time since the runs are aligned (s)",
    ] {
        assert!(svg.contains(words), "no {words:?} in\n{}", &svg[..4000]);
    }
    printed(&folder, &["plot", "a", "again", "--out", "both"], 0);
    let svg = fs::read_to_string(folder.join("both/compare-difference.svg")).unwrap();
    assert!(svg.contains("minus the first: rms 0.0 and 0.0 mrad"));
    let svg = fs::read_to_string(folder.join("both/compare-angles.svg")).unwrap();
    // Without a difference, the names of the folders.
    assert!(svg.contains(">a<") && svg.contains(">again<"));
}

/// Largest and RMS difference of a column.
pub(super) fn difference(run: &Value, column: &str) -> [f64; 2] {
    let quantities = run["quantities"].as_array().unwrap();
    let quantity = quantities.iter().find(|q| q["column"] == column).unwrap();
    ["max", "rms"].map(|key| quantity[key].as_f64().unwrap())
}

#[test]
fn runs_of_different_periods_are_compared_at_the_same_times() {
    let folder = folder("periods");
    for (name, period_us) in [("fast", 1_000), ("slow", 20_000)] {
        fs::create_dir_all(folder.join(name)).unwrap();
        let setup = Setup {
            period_us,
            ..Setup::best()
        };
        let run = Run {
            setup,
            ..Run::default()
        };
        record(&folder.join(name), run);
    }
    for (logs, periods) in [
        (["fast", "slow"], [1_000, 20_000]),
        (["slow", "fast"], [20_000, 1_000]),
    ] {
        let diff = json(&folder, &["diff", logs[0], logs[1], "--json"], 1);
        let run = &diff["runs"][0];
        assert_eq!(run["period_us"], serde_json::json!(periods));
        // 2 s at 20 ms.
        let ticks = run["ticks"].as_u64().unwrap();
        assert!((95..=101).contains(&ticks), "{run}");
        // By their numbers, ticks differ by up to the 0.25 rad between the setpoints.
        let [max, rms] = difference(run, "angle_rad_1");
        assert!(rms < 0.02 && max < 0.1, "{run}");
    }
    let text = printed(&folder, &["diff", "slow", "fast"], 1);
    for words in [
        "periods 20000 and 1000 µs: angles and speeds of B are",
        "setup.period_us\n    A  20000 µs",
        "    B  1000 µs",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );

    let args = ["plot", "fast", "slow", "--out", "both", "--format", "svg"];
    printed(&folder, &args, 0);
    let svg = fs::read_to_string(folder.join("both/compare-angles.svg")).unwrap();
    assert!(svg.contains(">period 1000 µs<") && svg.contains(">period 20000 µs<"));
}

#[test]
fn runs_without_the_event_are_not_called_the_same() {
    let folder = folder("event");
    let scenario = "title = \"t\"\n[[step]]\nat_s = 0\nidle = true\n[stop]\nafter_s = 0.5\n";
    fs::write(folder.join("idle.toml"), scenario).unwrap();
    let runs = ["a", "b"].map(|name| printed(&folder, &["run", "idle.toml", "--out", name], 0));
    let [a, b] = runs.each_ref().map(|run| run_folder(run));
    for command in ["diff", "plot"] {
        let output = armbridge(&folder, &[command, a, b]);
        let line = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(
            line.contains("never driven") && line.contains("--align start"),
            "{line}"
        );
    }
}

/// Numbers beside the lowest axis of a picture, left to right.
fn labels_of_the_lowest_axis(svg: &str) -> Vec<f64> {
    let mut rows = std::collections::BTreeMap::<i64, Vec<f64>>::new();
    for text in svg.split("<text ").skip(1) {
        let y = text.split("y=\"").nth(1).unwrap().split('"').next();
        let label = text.split_once('>').unwrap().1.split_once('<').unwrap().0;
        if let Ok(label) = label.parse() {
            let y: f64 = y.unwrap().parse().unwrap();
            rows.entry((10.0 * y) as i64).or_default().push(label);
        }
    }
    rows.pop_last().unwrap().1
}

#[test]
fn figures_have_the_period_in_force_and_keep_other_files() {
    let folder = folder("period");
    // The scenario sets 45 ms; the board begins with 1 ms.
    printed(&folder, &["run", "paper-upright"], 0);
    let run = fs::read_dir(folder.join("runs")).unwrap().next().unwrap();
    let run = run.unwrap().path();
    let own = fs::read(run.join("angles.svg")).unwrap();
    let args = ["plot", "--format", "svg"];
    let first = printed(&folder, &args, 0);
    let spectrum = fs::read_to_string(run.join("spectrum.svg")).unwrap();
    assert!(spectrum.contains("period 45000 µs"));
    // Half of 22.2 Hz is the highest frequency.
    assert_eq!(labels_of_the_lowest_axis(&spectrum).last(), Some(&10.0));
    // The axis reaches to the period.
    let timing = fs::read_to_string(run.join("timing.svg")).unwrap();
    assert!(timing.contains(">40000<"), "{timing}");

    // The run's own pictures are those of its log, and are the same again.
    assert!(!first.contains("-2.svg"), "{first}");
    assert_eq!(printed(&folder, &args, 0), first);
    let args = ["plot", "--format", "svg", "--what", "angles", "--from", "1"];
    let window = printed(&folder, &args, 0);
    assert!(window.ends_with("angles-2.svg\n"), "{window}");
    assert_eq!(fs::read(run.join("angles.svg")).unwrap(), own);
}

#[test]
fn pushes_are_marked_over_all_panels() {
    let folder = folder("pushes");
    printed(&folder, &["run", "push"], 0);
    let args = [
        "plot",
        "--format",
        "svg",
        "--what",
        "angles,tracking,torque",
        "--out",
        "new",
    ];
    printed(&folder, &args, 0);
    for name in ["angles", "tracking", "torque"] {
        let svg = fs::read_to_string(folder.join(format!("new/{name}.svg"))).unwrap();
        for words in ["push +0.50 N m on joint 1", "push −0.50 N m on joint 2"] {
            assert!(svg.contains(words), "no {words:?} in {name}");
        }
    }
}
