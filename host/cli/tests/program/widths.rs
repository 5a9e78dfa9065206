//! Tables and texts are no wider than a terminal.

use crate::program::Program;

const COLUMNS: usize = 80;

#[test]
fn what_commands_print_fits_a_terminal() {
    let program = Program::new("widths");
    let free_fall = ["run", "paper-free-fall"];
    program.prints(&[&free_fall, ["--quiet"].as_slice()].concat());
    for args in [
        ["info"].as_slice(),
        &["replay"],
        &[
            "replay",
            "--set",
            "controller.q=40,40,1,1",
            "--set",
            "limits.external_nm=0.05,0.05",
        ],
        &["identify", "run", "--dry-run"],
        &["identify", "paper"],
        &["params"],
        &["params", "--all"],
        &["params", "controller", "estimator"],
        &["config"],
        &["config", "--explain"],
        &["design"],
        &["design", "--natural", "20,20", "--estimator", "difference"],
        &["design", "--poles", "0.98+0.01i,0.98-0.01i,0.97,0.96"],
        &["plants"],
        &["plants", "--explain"],
        &["run", "--list"],
        &["run", "--explain"],
        &["status"],
    ] {
        let text = program.prints(args);
        // A path is as long as it is.
        let lines = text.lines().filter(|line| !line.starts_with("runs/"));
        for line in lines {
            assert!(line.chars().count() <= COLUMNS, "{args:?}: {line}");
        }
    }
}

#[test]
fn a_log_s_commands_are_in_words() {
    let program = Program::new("widths-words");
    program.prints(&["run", "paper-free-fall", "--quiet"]);
    let words: Vec<String> = program
        .prints(&["info"])
        .split_whitespace()
        .map(str::to_owned)
        .collect();
    let text = words.join(" ");
    for words in [
        "experiment for 6 s: joint 1 off, within -0.2 to 1.05 rad and 2 rad/s; joint 2 held,",
        "follow minimum-jerk to 0, 0 rad in 2 s",
    ] {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
    assert!(!text.contains("Some(") && !text.contains(" {"), "{text}");
}
