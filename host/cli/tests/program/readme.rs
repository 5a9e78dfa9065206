//! The results of the README that repeat are what its commands print.
//!
//! Values are read from the commands' JSON or text, written as the README writes them, and
//! compared with the cell of their row. The instruction counts are in the tests of the
//! emulator; figures of the wall clock, of campaigns and of identification on many arms do
//! not belong here.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Value of a row of the README's table of results.
fn result(row: &str) -> String {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let readme = fs::read_to_string(readme).unwrap();
    let line = readme
        .lines()
        .find_map(|line| line.strip_prefix(&format!("| {row} | ")));
    let line = line.unwrap_or_else(|| panic!("no row {row:?}"));
    line.split(" | ").next().unwrap().to_owned()
}

/// Standard output of a command in a folder of its own.
fn printed(args: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let output = command.args(args).current_dir(&folder).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{args:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&printed(args)).unwrap()
}

fn joints(run: &Value) -> impl Iterator<Item = &Value> {
    let segments = run["segments"].as_array().unwrap().iter();
    segments.flat_map(|segment| segment["joints"].as_array().unwrap())
}

/// Largest error of a joint at rest, in mrad.
fn farthest_at_rest_mrad(run: &Value) -> f64 {
    let errors = joints(run).filter(|joint| joint["is_at_rest"] == true);
    errors
        .map(|joint| joint["steady_state_error_mrad"].as_f64().unwrap().abs())
        .fold(0.0, f64::max)
}

#[test]
fn the_demo_has_the_results_of_the_readme() {
    let demo = json(&["run", "demo", "--json"]);
    let bus = &demo["bus_us"];
    assert_eq!(
        result("bus time of a tick"),
        format!(
            "{:.0} µs, at most {} µs",
            bus["mean"].as_f64().unwrap(),
            bus["max"]
        )
    );
    let [first, second] = [0, 1].map(|joint| {
        let joint = joints(&demo).nth(joint).unwrap();
        joint["settling_time_s"].as_f64().unwrap()
    });
    assert_eq!(
        result("settled within 20 mrad"),
        format!("{first:.2}, {second:.2} s")
    );
    assert_eq!(
        result("farthest off at rest"),
        format!("{:.1} mrad", farthest_at_rest_mrad(&demo))
    );
    let paper = json(&["run", "demo", "--control", "paper", "--json"]);
    assert_eq!(
        result("the same, observer and LQR"),
        format!("{:.1} mrad", farthest_at_rest_mrad(&paper))
    );
}

#[test]
fn the_paper_identified_has_the_friction_of_the_readme() {
    let value = result("friction b1, fall and push");
    let b1 = value.strip_suffix(" for both").unwrap();
    let printed = printed(&["identify", "paper"]).replace('\n', " ");
    let words = format!("0.421 and 0.239, belong to one arm with b1 = {b1} N m s/rad");
    assert!(printed.contains(&words), "no {words:?} in {printed}");
}

#[test]
fn the_sine_is_tracked_as_the_readme_says() {
    let trials = json(&[
        "trials",
        "--seeds",
        "1..20",
        "--controller",
        "computed-torque",
        "--natural",
        "20,20",
        "--initial",
        "0,0",
        "--reference",
        "sine:0.3,0.3,1",
        "--json",
    ]);
    let runs = trials["outcomes"].as_array().unwrap();
    let errors = runs
        .iter()
        .flat_map(|run| run["tracking_rms_mrad"].as_array().unwrap());
    let worst = errors.map(|rms| rms.as_f64().unwrap()).fold(0.0, f64::max);
    assert_eq!(
        result("rms error, 0.3 rad at 1 Hz"),
        format!("{worst:.1} mrad")
    );
}
