//! The program on links that fail, and on links that do not.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::time::{Duration, Instant};

use armbridge_client::session::Request;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Drive, Fault, Hello, Mode, StopSource, ToHost};
use armbridge_link::schema;

#[cfg(unix)]
use super::program::interrupt;
use super::program::{TCP, assert_ends, run, spawn, text};
use armbridge_tests::cable::Cable;
use armbridge_tests::channel_host::Manned;
use armbridge_tests::served_board::Served;

#[test]
fn the_board_is_told_in_words_and_in_json() {
    let board = Served::on(TCP);
    let output = run(&board.link, &["status"]);
    for words in [
        "power was switched on",
        "IDLE: motors off",
        "Morpheus, 1000000 baud, ready",
        " rad (count ",
        "0 lost, 0 damaged",
        "median ",
    ] {
        assert_ends(&output, 0, words);
    }
    let output = run(&board.link, &["status", "--json"]);
    let status: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(status["mode"], "idle");
    assert_eq!(status["ready"], true);
    assert!(status["frames_per_s"].as_f64() > Some(100.0), "{status}");
    assert!(
        status["round_trip_median_ms"].as_f64() > Some(0.0),
        "{status}"
    );
    board.until_off();
}

#[test]
fn stop_latches_status_explains_and_clear_clears() {
    let board = Served::on(TCP);
    let stopped = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
    assert_ends(&run(&board.link, &["stop"]), 0, "stopped: emergency stop");
    assert_eq!(board.seen().mode, stopped);
    assert_ends(
        &run(&board.link, &["status"]),
        0,
        "FAULT: motors off, latched",
    );
    assert_ends(&run(&board.link, &["disarm"]), 0, "a fault is latched");
    assert_ends(
        &run(&board.link, &["arm", "--for", "1"]),
        2,
        "`armbridge clear`",
    );
    let cleared = "the fault emergency_stop_host is cleared; motors are off";
    assert_ends(&run(&board.link, &["clear"]), 0, cleared);
    assert_ends(&run(&board.link, &["clear"]), 0, "no fault was latched");
    assert_eq!(board.seen().mode, Mode::Idle);
    assert_ends(&run(&board.link, &["arm", "--for", "0.3"]), 0, "; disarmed");
    board.until_off();
    assert_eq!(board.seen().mode, Mode::Idle);
}

#[cfg(unix)]
#[test]
fn ctrl_c_disarms_first_and_then_ends() {
    let board = Served::on("pty:");
    let child = spawn(&board.link, &["arm"]);
    board.until("armed", |seen| seen.mode == Mode::Armed);
    interrupt(&child);
    assert_ends(&child.wait_with_output().unwrap(), 0, "; disarmed");
    board.until_off();
    assert_eq!(board.seen().mode, Mode::Idle, "no fault");
}

#[test]
fn a_killed_host_leaves_a_board_that_acts_by_itself() {
    let board = Served::on(TCP);
    let mut child = spawn(&board.link, &["arm"]);
    board.until("armed", |seen| seen.mode == Mode::Armed);
    child.kill().unwrap();
    child.wait().unwrap();
    let silent = Mode::Fault(Fault::HostSilent);
    board.until("the host is found silent", |seen| seen.mode == silent);
    board.until_off();
}

#[test]
fn a_reset_in_mid_run_is_explained_and_nothing_is_armed() {
    let board = Served::on(TCP);
    let child = spawn(&board.link, &["arm", "--quiet"]);
    board.until("armed", |seen| seen.mode == Mode::Armed);
    board.reset();
    let output = child.wait_with_output().unwrap();
    assert_ends(
        &output,
        1,
        "the board was reset, its motors are off: its watchdog",
    );
    board.until_off();
    board.until("idle", |seen| seen.mode == Mode::Idle);
}

#[test]
fn a_link_that_does_not_come_back_ends_the_program() {
    let board = Served::on(TCP);
    let cable = Cable::to(&board.link);
    let child = spawn(&cable.link, &["arm", "--quiet"]);
    board.until("armed", |seen| seen.mode == Mode::Armed);
    cable.unplug();
    let output = child.wait_with_output().unwrap();
    assert_ends(&output, 2, "did not come back in 0.5 s");
    board.until_off();
}

#[test]
fn a_second_host_watches_and_stops_and_does_not_command() {
    let board = Served::on(TCP);
    let first = Manned::on(&board.link, Duration::ZERO);
    first.hold(&board);
    // The commander of this test is a thread of it.
    let commands = format!("(process {}) commands", std::process::id());
    for (command, code, words) in [
        (["status"].as_slice(), 0, "RUNNING"),
        (&["params", "limits"], 0, "limits.hold_ms"),
        (&["arm", "--for", "1"], 2, "end that program first"),
        (
            &["params", "limits.hold_ms=70"],
            2,
            "end that program first",
        ),
        (&["run", "upright"], 2, "`armbridge watch --observe`"),
    ] {
        let begun = Instant::now();
        let output = run(&board.link, command);
        let took = begun.elapsed();
        assert_ends(&output, code, words);
        assert!(text(&output.stderr).starts_with("armbridge: "));
        assert!(text(&output.stderr).contains(&commands));
        assert_eq!(output.stdout.is_empty(), code != 0);
        // At once, and with no words about servos and their power.
        println!("{command:?} took {took:?}");
        assert!(code == 0 || took < Duration::from_secs(2), "{took:?}");
    }
    let before = first.received().records;
    armbridge_tests::served_board::until("records go on", || {
        first.received().records > before + 100
    });
    let received = first.received();
    assert_eq!((received.lost, received.partings), (0, 0));
    assert_eq!(received.mode.and_then(Mode::drive), Some(Drive::Regulate));
    assert_ends(&run(&board.link, &["stop"]), 0, "stopped: emergency stop");
    board.until_off();
    first.ask(Request::Leave);
    first.end().unwrap();
    board.until_off();
    // The link is free again.
    let cleared = "the fault emergency_stop_host is cleared; motors are off";
    assert_ends(&run(&board.link, &["clear"]), 0, cleared);
    assert_ends(&run(&board.link, &["clear"]), 0, "no fault was latched");
}

#[test]
fn another_version_is_told() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let link = format!("tcp://{}", listener.local_addr().unwrap());
    let mut hello = Hello {
        version: [7, 8, 9],
        ..schema::HELLO
    };
    hello.schema[0] ^= 1;
    let other = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let frame = Encoder::default().encode(&ToHost::Hello(hello)).1.to_vec();
        stream.write_all(&frame).unwrap();
        // Until the host has gone.
        let _ = stream.read_to_end(&mut Vec::new());
    });
    let output = run(&link, &["status"]);
    assert_ends(&output, 2, "version 7.8.9; this host");
    assert_ends(&output, 2, "build and flash both from the same source");
    other.join().unwrap();
}

#[test]
fn what_is_no_link_is_told() {
    for (link, words) in [
        ("tcp://127.0.0.1:9", "is the other side listening?"),
        ("serial:///dev/no-such-device", "is it plugged in?"),
        ("pty:///dev/no-such-device", "is it plugged in?"),
        ("emulate:/no/such.elf", "no firmware image at /no/such.elf"),
    ] {
        assert_ends(&run(&link, &["status"]), 2, words);
    }
}
