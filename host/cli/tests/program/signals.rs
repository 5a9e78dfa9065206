//! Signals that end commands: their exit codes, and their last line.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use armbridge_link::message::Mode;
use armbridge_tests::served_board::Served;

use super::links::program::{assert_ends, signal, spawn};

/// Longest time to an end on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// Exit code, and the output on standard error after the line with `ready`.
fn ended(args: &[&str], ready: &str, name: &str) -> (Option<i32>, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_armbridge"))
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains(ready) {
        line.clear();
        assert!(
            stderr.read_line(&mut line).unwrap() > 0,
            "{args:?} has ended"
        );
    }
    signal(&child, name);
    let code = end_of(&mut child);
    let mut rest = String::new();
    stderr.read_to_string(&mut rest).unwrap();
    (code, rest)
}

fn end_of(child: &mut Child) -> Option<i32> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_server_ends_by_ctrl_c_with_0_and_says_so() {
    let tcp = "tcp://127.0.0.1:0";
    let board = ["serve", "board", "--link", "sim:"];
    for (args, ready) in [
        ([&board[..], &["--listen", tcp]].concat(), "end with ctrl-c"),
        (
            [&board[..], &["--listen", "pty:"]].concat(),
            "end with ctrl-c",
        ),
        (
            [&board[..], &["--transparent", tcp]].concat(),
            "transparent port",
        ),
        (vec!["serve", "servos", "--listen", tcp], "end with ctrl-c"),
        (
            vec!["serve", "servos", "--listen", "pty:"],
            "end with ctrl-c",
        ),
    ] {
        for (name, expected, words) in [
            ("INT", 0, "ended by ctrl-c"),
            ("TERM", 143, "ended by a request to terminate"),
            ("HUP", 129, "ended by a terminal that hung up"),
        ] {
            let (code, rest) = ended(&args, ready, name);
            assert_eq!(code, Some(expected), "{args:?} {name}: {rest}");
            assert!(rest.contains(words), "{args:?} {name}: {rest}");
        }
    }
}

#[test]
fn a_request_to_terminate_disarms_and_is_in_the_exit_code() {
    for args in [&["arm"][..], &["arm", "--for", "60"]] {
        let board = Served::on("pty:");
        let child = spawn(&board.link, args);
        board.until("armed", |seen| seen.mode == Mode::Armed);
        signal(&child, "TERM");
        assert_ends(&child.wait_with_output().unwrap(), 143, "; disarmed");
        board.until_off();
        assert_eq!(board.seen().mode, Mode::Idle, "no fault");
    }
}
