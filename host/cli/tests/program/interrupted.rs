//! Signals in the midst of work: what is done is kept, nothing is left by half, and the exit
//! code is the signal's.

use std::fs;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::program::{Program, names, stderr};

/// Sends a signal to a command once `is_ready`.
#[cfg(unix)]
fn signalled(
    program: &Program,
    args: &[&str],
    signal: &str,
    is_ready: impl Fn(u32) -> bool,
) -> Output {
    let mut command = program.command(args);
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    while !is_ready(child.id()) {
        assert!(child.try_wait().unwrap().is_none(), "{args:?} ended");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let id = child.id().to_string();
    let sent = Command::new("kill").args([signal, &id]).status().unwrap();
    assert!(sent.success());
    child.wait_with_output().unwrap()
}

/// Interrupts a command that has computed for 6 s, as ctrl-C does.
#[cfg(target_os = "linux")]
fn interrupted(program: &Program, args: &[&str]) -> Output {
    let has_computed = |id: u32| {
        let stat = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        // After the name, in brackets: user and system time are the 12th and 13th.
        let fields = stat.rsplit(')').next().unwrap_or_default();
        let times = fields.split_whitespace().skip(11).take(2);
        let ticks: u64 = times.filter_map(|time| time.parse::<u64>().ok()).sum();
        ticks >= 600
    };
    signalled(program, args, "-INT", has_computed)
}

/// Whether a file in a run folder has this name and more than `bytes` bytes.
fn has_begun(program: &Program, name: &str, bytes: u64) -> bool {
    let runs = program.path("runs");
    let mut folders = names(&runs).into_iter();
    folders.any(|folder| {
        let file = runs.join(folder).join(name);
        fs::metadata(file).is_ok_and(|file| file.len() > bytes)
    })
}

#[cfg(unix)]
#[test]
fn ctrl_c_during_the_baseline_is_no_error_of_the_run() {
    let program = Program::new("output-baseline");
    let begun = |_| has_begun(&program, "baseline.mcap", 0);
    let output = signalled(
        &program,
        &["run", "demo", "--duration", "600"],
        "-INT",
        begun,
    );
    let line = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{line}");
    assert!(
        line.contains("ended by ctrl-c before the arm was armed"),
        "{line}"
    );
    assert_eq!(names(&program.path("runs")), [""; 0]);
}

#[cfg(unix)]
#[test]
fn a_signal_that_ends_a_run_is_named() {
    let program = Program::new("output-terminated");
    // A log begins with half of that, before the arm is armed.
    let begun = |_| has_begun(&program, "run.mcap", 1_000_000);
    let output = signalled(
        &program,
        &["run", "upright", "--duration", "3000"],
        "-TERM",
        begun,
    );
    let printed = String::from_utf8_lossy(&output.stdout).replace('\n', " ") + &stderr(&output);
    assert_eq!(output.status.code(), Some(143), "{printed}");
    let headline = "interrupted by a request to terminate; the motors are off";
    assert!(printed.contains(headline), "{printed}");
    assert!(!printed.contains("ctrl-c"), "{printed}");
}

/// Where it computes or reads at length, as well as between two figures.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_paper_and_plot_with_a_line_and_leaves_nothing() {
    let program = Program::new("output-paper-ctrl-c");
    let begun = |_| !names(&program.path("runs")).is_empty();
    let output = signalled(&program, &["paper"], "-INT", begun);
    let line = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{line}");
    assert!(
        line.contains("ended by ctrl-c before the paper's numbers"),
        "{line}"
    );
    assert_eq!(names(&program.path("runs")), [""; 0]);

    program.prints(&["run", "upright", "--duration", "600", "--quiet"]);
    let begun_at = std::time::Instant::now();
    let begun = |_| begun_at.elapsed() > std::time::Duration::from_millis(300);
    let args = ["plot", "--out", "plots"];
    let output = signalled(&program, &args, "-TERM", begun);
    let line = stderr(&output);
    assert_eq!(output.status.code(), Some(143), "{line}");
    assert!(line.contains("ended by a request to terminate"), "{line}");
    let left = names(&program.path("plots"));
    assert!(!left.iter().any(|name| name.contains(".part")), "{left:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_no_half_export() {
    let program = Program::new("output-export-ctrl-c");
    program.prints(&["run", "upright", "--duration", "150", "--quiet"]);
    let runs = program.path("runs");
    let folder = runs.join(&names(&runs)[0]);
    let is_part = |name: &String| name.contains(".part");
    let begun = |_| {
        let part = names(&folder).into_iter().find(is_part);
        part.is_some_and(|part| fs::metadata(folder.join(part)).is_ok_and(|it| it.len() > 0))
    };
    let output = signalled(&program, &["export", "csv"], "-INT", begun);
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let left = names(&folder);
    assert!(
        !left.iter().any(is_part) && !left.contains(&"run.csv".into()),
        "{left:?}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_keeps_the_trials_and_cases_that_are_done() {
    let program = Program::new("output-ctrl-c");
    let args = [
        "trials",
        "--seeds",
        "1..10000",
        "--duration",
        "0.5",
        "--json",
    ];
    let output = interrupted(&program, &args);
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("of 10000 seeds"),
        "{}",
        stderr(&output)
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let outcomes = report["outcomes"].as_array().unwrap();
    assert!((1..10_000).contains(&outcomes.len()), "{}", outcomes.len());

    let output = interrupted(
        &program,
        &["fault-campaign", "--seeds", "1000000", "--json"],
    );
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let cases = |group: &str| report[group]["cases"].as_u64().unwrap();
    assert!(cases("all_singles") + cases("all_pairs") > 0, "{report}");
}
