//! Pushes and hands on a served arm, from a second terminal.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::Duration;

use armbridge_link::message::{Fault, Mode, StopSource};
use armbridge_tests::channel_host::Manned;
use armbridge_tests::served_board::{Seen, Served};

use super::program::{TCP, assert_ends, command, run};

const STOPPED: Mode = Mode::Fault(Fault::EmergencyStop(StopSource::Host));

/// The arm is at these angles, to the last bit of the hand's.
fn is_at(seen: &Seen, rad: [f64; 2]) -> bool {
    let [first, second] = [0, 1].map(|joint| (seen.angle_rad[joint] - rad[joint]).abs());
    first.max(second) < 1e-6
}

#[test]
fn a_fallen_arm_is_lifted_pushed_and_released() {
    let board = Served::on(TCP);
    let first = Manned::on(&board.link, Duration::ZERO);
    first.hold(&board);
    // The motors have the arm, which is pushed all the same.
    let error = run(&board.link, &["hand", "0.3,-0.2"]);
    assert_ends(
        &error,
        2,
        "the motors hold the arm: `armbridge disarm` first",
    );
    let push = |options: &[&str], words: &str| {
        assert_ends(&run(&board.link, &[&["push"], options].concat()), 0, words);
    };
    push(
        &["--joint", "2", "--torque", "-0.8"],
        "pushed: joint 2, -0.8 N m for 0.1 s",
    );
    board.until("it is off its setpoint", |seen| seen.angle_rad[1] < -0.02);
    // It falls, is lifted, and stays where the hand is.
    assert_ends(&run(&board.link, &["stop"]), 0, "stopped: emergency stop");
    push(
        &["--torque", "2", "--duration", "0.3"],
        "pushed: joint 1, 2 N m for 0.3 s",
    );
    board.until("it has fallen", |seen| seen.angle_rad[0] > 0.8);
    let output = run(&board.link, &["hand", "0.3,-0.2", "--duration", "1"]);
    assert_ends(
        &output,
        0,
        "held at +0.300 and -0.200 rad, until a motor drives it",
    );
    board.until("it is lifted", |seen| {
        is_at(seen, [0.3_f32, -0.2].map(f64::from))
    });
    assert_eq!(board.seen().mode, STOPPED, "no command reached the board");
    assert_ends(&run(&board.link, &["hand", "--release"]), 0, "lets go");
    board.until("it falls again", |seen| seen.angle_rad[0].abs() > 0.8);
    let received = first.received();
    assert_eq!((received.lost, received.partings), (0, 0));
}

#[test]
fn a_calibration_is_practised_from_two_terminals() {
    let board = Served::on(TCP);
    let mut child = command(&board.link, &["calibrate"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut answers = child.stdin.take().unwrap();
    let poses = [
        ("Joint 1: hold it at its zero", "0,0", [0.0, 0.0]),
        ("Joint 1: turn it alone", "0.4,0", [0.4, 0.0]),
        ("Joint 2: hold it at its zero", "0,0", [0.0, 0.0]),
        ("Joint 2: turn it alone", "0,0.4", [0.0, 0.4]),
    ];
    let asked = BufReader::new(child.stderr.take().unwrap()).lines();
    // On a busy machine a question may come again: records from before the hand was there.
    for line in asked.map(Result::unwrap) {
        let pose = poses
            .iter()
            .find(|(question, ..)| line.starts_with(question));
        if let Some((_, hand, rad)) = pose {
            let moved = run(&board.link, &["hand", hand, "--duration", "1"]);
            assert_ends(&moved, 0, "the simulated arm is held at");
            assert!(is_at(&board.seen(), *rad), "{line}: {:?}", board.seen());
            answers.write_all(b"\n").unwrap();
        } else if line.starts_with("Save this on the board?") {
            answers.write_all(b"y\n").unwrap();
        }
    }
    let output = child.wait_with_output().unwrap();
    // The change was shown with the question.
    assert_eq!(output.stdout, b"Saved on the board.\n");
    assert_ends(&output, 0, "");
    let zeros = ["joint1.zero_count", "joint2.zero_count"];
    let saved = run(&board.link, &["params", zeros[0], zeros[1], "--json"]);
    let saved: serde_json::Value = serde_json::from_slice(&saved.stdout).unwrap();
    for joint in [0, 1] {
        // The virtual arm is mounted as the paper's, upright at the middle of the track.
        let count = saved[joint]["value"].as_f64().unwrap();
        assert!((count - 512.0).abs() < 2.0, "{saved}");
    }
}

#[test]
fn where_no_arm_can_be_touched_the_error_says_so() {
    // A listener that is no server of a board, and never answers.
    let silent = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let silent = format!("tcp://{}", silent.local_addr().unwrap());
    for (link, words) in [
        (
            "serial:///dev/ttyACM9",
            "only a simulated arm can be touched",
        ),
        ("usb:", "only a simulated arm can be touched"),
        ("pty:///dev/pts/9", "one program at a time"),
        (
            "sim:",
            "`armbridge serve board --listen tcp://127.0.0.1:7001`",
        ),
        (&silent, "is no `armbridge serve board`"),
    ] {
        for touch in [&["push"][..], &["hand", "0,0"]] {
            assert_ends(&run(&link, touch), 2, words);
        }
    }
    let words = "armbridge: sim: the input ended before the last answer";
    assert_ends(&run(&"sim:", &["calibrate"]), 2, words);
    let board = Served::on(TCP);
    assert_ends(&run(&board.link, &["status"]), 0, ", session 0x");
    for (touch, words) in [
        (&["hand", "2,0"][..], "two angles from -1.4 to 1.4"),
        (
            &["hand", "0,0", "--duration", "0.5"],
            "seconds from 1 to 60",
        ),
        (&["hand"], "required"),
        (
            &["hand", "0.3", "-0.2"],
            "two angles from -1.4 to 1.4 rad, as 0.3,-0.25",
        ),
        (&["hand", "0.3,-0.2", "-0.2"], "both angles are one word"),
        (&["push", "--torque", "7"], "from -6 to 6 N m"),
        (&["push", "--joint", "3"], "1..=2"),
    ] {
        assert_ends(&run(&board.link, touch), 2, words);
    }
}

/// The server prints the commands that touch its arm, and the protocol of its servos.
#[test]
fn a_server_names_its_commands_and_its_protocol() {
    let first_lines = |args: &[&str]| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .arg("serve")
            .args(args)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let lines: Vec<String> = lines.take(3).map(Result::unwrap).collect();
        child.kill().unwrap();
        child.wait().unwrap();
        lines.join("\n")
    };
    let listen = ["--listen", TCP];
    for (what, words) in [
        (
            &["board", "--link", "sim:"][..],
            "armbridge push     --link tcp://127.0.0.1:",
        ),
        (
            &["servos"],
            "Protocol 1.0, as the vendor's SDK does, with\n  --firmware stock",
        ),
        (
            &["servos", "--firmware", "stock"],
            "they speak Dynamixel Protocol 1.0",
        ),
    ] {
        let shown = first_lines(&[what, &listen].concat());
        assert!(shown.contains(words), "{what:?}: {shown}");
        assert!(
            shown.lines().skip(1).all(|line| line.chars().count() <= 80),
            "{shown}"
        );
    }
}
