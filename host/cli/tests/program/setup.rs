//! `armbridge setup` in the terminal: its table, its exit codes, and a second run that goes on.
//! Its steps on a board's own image are in `tests/emulator/board_image`.

use std::process::{Command, Output, Stdio};

use armbridge_tests::served_board::Served;
use serde_json::Value;

use crate::links::program::{TCP, assert_ends, run};

fn setup(args: &[&str], answers: &str) -> Output {
    use std::io::Write;
    let mut child = Command::new(env!("CARGO_BIN_EXE_armbridge"))
        .arg("setup")
        .args(args)
        .env_remove("ARMBRIDGE_LINK")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    // It may have ended before it read them.
    let _ = input.write_all(answers.as_bytes());
    drop(input);
    child.wait_with_output().unwrap()
}

#[test]
fn a_simulated_board_must_be_served() {
    let output = setup(&["--link", "sim:"], "");
    assert_ends(&output, 2, "serve it, as `armbridge setup --help` shows");
}

#[test]
fn what_is_missing_is_named_with_what_to_do() {
    let closed = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let at = format!("tcp://{}", closed.local_addr().unwrap());
    drop(closed);
    let output = setup(&["--link", &at, "--json"], "");
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["complete"], false);
    let steps = report["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 2, "{report}");
    assert_eq!(
        (&steps[0]["step"], &steps[0]["state"]),
        (&"computer".into(), &"n/a".into())
    );
    assert_eq!(
        (&steps[1]["step"], &steps[1]["state"]),
        (&"board".into(), &"missing".into())
    );
    let remedy = steps[1]["remedy"].as_str().unwrap();
    assert!(remedy.contains("armbridge setup"), "{remedy}");
}

/// A fault stops it before any question, and a motion that is declined moves nothing.
#[test]
fn a_latched_fault_and_a_no_move_nothing() {
    let board = Served::on(TCP);
    let link = board.link.to_string();
    assert_ends(&run(&board.link, &["stop"]), 0, "stopped");
    let stopped = setup(&["--link", &link], "");
    assert_eq!(stopped.status.code(), Some(1));
    let text = String::from_utf8(stopped.stdout).unwrap();
    assert!(text.contains("board        missing  fault: "), "{text}");
    assert!(
        text.contains(&format!("armbridge clear --link {link}")),
        "{text}"
    );

    assert_ends(&run(&board.link, &["clear"]), 0, "cleared");
    let zero = "joint1.zero_count=515";
    assert_ends(&run(&board.link, &["params", zero, "--save"]), 0, "");
    let declined = setup(&["--link", &link], "n\n");
    assert_eq!(declined.status.code(), Some(1));
    let text = String::from_utf8(declined.stdout).unwrap();
    assert!(
        text.contains("calibration  ok       zeros 515.0 forward"),
        "{text}"
    );
    assert!(
        text.contains("direction    missing  declined: nothing has moved"),
        "{text}"
    );
    assert!(!board.seen().mode.is_armed());
    // Without an answer as well.
    assert_ends(&setup(&["--link", &link], ""), 2, "the input ended before");
    assert!(!board.seen().mode.is_armed());
}
