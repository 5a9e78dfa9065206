//! `armbridge stop` while another program has the link.

use std::process::Child;
use std::time::Duration;

use armbridge_client::Host;
use armbridge_client::session::{ChannelHost, Request};
use armbridge_client::transport::stop_socket::{self, Answer, BoardKey, Order};
use armbridge_client::transport::{LinkUri, drive};
use armbridge_link::message::{Command, Drive, Fault, Mode, StopSource};
use armbridge_tests::channel_host::{Manned, options};
use armbridge_tests::served_board::{Served, until};

use super::program::{Terminals, assert_ends, run, signal, spawn};

const STOPPED: Mode = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
/// Longest time from a request to torque off, in simulated µs.
const STOP_US: u64 = 100_000;

/// The answers of the owners.
fn answers(link: &LinkUri, order: Order) -> Vec<Answer> {
    let asked = stop_socket::ask(BoardKey::of(link).as_ref(), order);
    asked.into_iter().map(|asked| asked.answer).collect()
}

/// The owner's answer, once its socket is there.
fn ask(link: &LinkUri, order: Order) -> Answer {
    let mut all = Vec::new();
    until("the socket is there", || {
        all = answers(link, order);
        !all.is_empty()
    });
    assert_eq!(all.len(), 1);
    all.remove(0)
}

fn stopped() -> Answer {
    Answer::Stopped("emergency_stop_host".into())
}

#[test]
fn a_second_terminal_stops_within_100_ms() {
    let board = Served::on("pty:");
    let owner = Manned::on(&board.link, Duration::ZERO);
    owner.hold(&board);
    let asked_us = board.seen().now_us;
    assert_eq!(ask(&board.link, Order::Stop), stopped());
    // The answer comes after the board's report.
    let took_us = board.seen().now_us - asked_us;
    println!("stopped and reported after {took_us} us");
    board.until("stopped", |seen| seen.mode == STOPPED);
    assert!(took_us < STOP_US, "{took_us} us");
    board.until_off();
    assert_eq!(owner.received().lost, 0);
}

#[test]
fn every_program_that_has_the_link_stops() {
    for (args, code, words) in [
        (["arm"].as_slice(), 1, "stop"),
        (&["run", "upright"], 1, "FAULT emergency_stop_host"),
    ] {
        let board = Served::on("pty:");
        let owner = spawn(&board.link, args);
        board.until("motors may be on", |seen| seen.mode.is_armed());
        let output = run(&board.link, &["stop"]);
        let by_owner = "stopped by the program that has /dev/pts/";
        assert_ends(&output, 0, by_owner);
        assert_ends(&output, 0, "the board reports emergency_stop_host");
        board.until_off();
        assert_ends(&owner.wait_with_output().unwrap(), code, words);
        // A host that joins later learns how the stop ended.
        let seen_off = "both motors are seen to be off";
        assert_ends(&run(&board.link, &["status"]), 0, seen_off);
        // Nobody has it now, and the board takes the stop itself.
        assert_ends(&run(&board.link, &["stop"]), 0, "stopped: emergency stop");
        assert_ends(
            &run(&board.link, &["clear"]),
            0,
            "is cleared; motors are off",
        );
    }
}

/// A host that does not know of stops by others.
struct Plain(ChannelHost);

impl Host for Plain {
    type Error = <ChannelHost as Host>::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
        self.0.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.0.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.0.is_done()
    }
}

#[test]
fn a_host_without_a_stop_of_its_own_is_stopped_too() {
    let board = Served::on("pty:");
    let (host, controls) = ChannelHost::new();
    let link = board.link.clone();
    let thread =
        std::thread::spawn(move || drive(&link, options(Duration::ZERO), Plain(host)).1.is_ok());
    board.until("idle", |seen| seen.mode == Mode::Idle);
    controls.request(Request::Arm).unwrap();
    let hold = Request::Command(Command::Regulate([0.0; 2]));
    controls.request(hold).unwrap();
    board.until("held", |seen| seen.mode.drive() == Some(Drive::Regulate));
    assert_eq!(ask(&board.link, Order::Disarm), Answer::Disarmed);
    board.until_off();
    assert_eq!(board.seen().mode, Mode::Idle);
    assert_eq!(ask(&board.link, Order::Stop), stopped());
    board.until("stopped", |seen| seen.mode == STOPPED);
    controls.request(Request::Leave).unwrap();
    assert!(thread.join().unwrap());
}

#[test]
fn a_socket_that_is_left_behind_is_in_nobodys_way() {
    let board = Served::on("pty:");
    for _ in 0..2 {
        let mut owner = spawn(&board.link, &["arm"]);
        board.until("armed", |seen| seen.mode == Mode::Armed);
        owner.kill().unwrap();
        owner.wait().unwrap();
        assert_eq!(answers(&board.link, Order::Stop), []);
        assert_ends(&run(&board.link, &["stop"]), 0, "stopped: emergency stop");
        assert_ends(
            &run(&board.link, &["clear"]),
            0,
            "is cleared; motors are off",
        );
    }
    // And its name is taken again.
    let owner = Manned::on(&board.link, Duration::ZERO);
    owner.hold(&board);
    assert_eq!(ask(&board.link, Order::Stop), stopped());
}

#[test]
fn where_nothing_can_be_stopped_the_error_says_what_else_to_do() {
    for link in ["tcp://127.0.0.1:9", "pty:///dev/no-such-device"] {
        assert_ends(
            &run(&link, &["stop"]),
            2,
            "use the stop switch at the board, or the switch of the servos' supply",
        );
    }
    // Another program has it, which is none of ours.
    let pty = armbridge_client::pty::Pty::open().unwrap();
    let name = std::path::Path::new(pty.name());
    let _held = armbridge_client::servo_bus::serial_device::open(name, 1_000_000).unwrap();
    let link = format!("pty://{}", pty.name());
    let output = run(&link, &["stop"]);
    assert_ends(&output, 2, "in use by another program");
    assert_ends(&output, 2, "or the switch of the servos' supply");
}

/// A program that has armed the board, on this link.
fn armed(terminals: &Terminals, board: &Served, link: &str) -> Child {
    let owner = terminals.spawn(&["arm", "--quiet", "--link", link]);
    board.until("armed", |seen| seen.mode == Mode::Armed);
    owner
}

/// A program on a link of every kind, with the one line of a stop in another terminal.
#[test]
fn a_stop_without_a_link_stops_what_is_running_and_names_it() {
    let terminals = Terminals::new("stop-all");
    for (served, scheme) in [
        ("pty:", "pty://"),
        ("pty:", "serial://"),
        ("tcp://127.0.0.1:0", ""),
    ] {
        let board = Served::on(served);
        let link = match &board.link {
            LinkUri::Pty(Some(path)) => format!("{scheme}{}", path.display()),
            link => link.to_string(),
        };
        let owner = armed(&terminals, &board, &link);
        let output = terminals.run(&["stop"]);
        let name = link.rsplit("//").next().unwrap();
        assert_ends(&output, 0, &format!("{name} (process {})", owner.id()));
        assert_ends(&output, 0, "the board reports emergency_stop_host");
        board.until("stopped", |seen| seen.mode == STOPPED);
        board.until_off();
        assert_ends(&owner.wait_with_output().unwrap(), 1, "stop");
    }
}

/// A configuration that cannot be read hides no board that is running.
#[test]
fn a_stop_with_a_broken_configuration_stops_what_is_running() {
    let terminals = Terminals::new("stop-broken-config");
    let board = Served::on("pty:");
    let link = board.link.to_string();
    let owner = armed(&terminals, &board, &link);
    terminals.configure("link = \n");
    let output = terminals.run(&["stop"]);
    assert_ends(&output, 2, "NOT ALL WERE STOPPED: ");
    assert_ends(&output, 2, "the board reports emergency_stop_host");
    board.until_off();
    assert_eq!(owner.wait_with_output().unwrap().status.code(), Some(1));
}

/// The case that was found: a simulated run went on, and a board made for the stop was stopped.
#[test]
fn a_simulated_run_in_another_terminal_is_stopped_and_no_other_board_is_made() {
    let terminals = Terminals::new("stop-sim");
    for args in [&["stop"][..], &["stop", "--link", "sim:"], &["disarm"]] {
        let output = terminals.run(args);
        assert_ends(&output, 2, "NOTHING WAS ");
        assert_ends(&output, 2, "the switch of the servos' supply");
        assert!(output.stdout.is_empty());
    }
    assert_ends(&terminals.run(&["clear"]), 2, "give its --link");
    for (args, code, words) in [
        (["stop"].as_slice(), 1, "FAULT emergency_stop_host"),
        (&["stop", "--link", "sim:"], 1, "FAULT emergency_stop_host"),
        (&["disarm"], 2, "another program disarmed the board"),
    ] {
        let owner = terminals.spawn(&["run", "upright", "--pace", "real"]);
        until("the run has begun", || terminals.logged_bytes() > 100_000);
        let output = terminals.run(args);
        assert_ends(&output, 0, &format!("sim: (process {})", owner.id()));
        assert_ends(&owner.wait_with_output().unwrap(), code, words);
        terminals.forget_runs();
    }
}

#[test]
fn a_program_that_hangs_is_named_and_the_switch_too() {
    let terminals = Terminals::new("stop-frozen");
    let board = Served::on("pty:");
    let link = board.link.to_string();
    let owner = armed(&terminals, &board, &link);
    signal(&owner, "STOP");
    let output = terminals.run(&["stop"]);
    assert_ends(&output, 2, "NOTHING WAS STOPPED: /dev/pts/");
    let process = format!("is in use by process {}: it does not answer", owner.id());
    assert_ends(&output, 2, &process);
    assert_ends(&output, 2, "use the stop switch at the board");
    // By itself, since its host is silent.
    board.until_off();
    signal(&owner, "CONT");
    assert!(owner.wait_with_output().unwrap().status.code().is_some());
}

#[test]
fn disarm_in_another_terminal_is_no_fault() {
    let terminals = Terminals::new("disarm-all");
    for served in ["pty:", "tcp://127.0.0.1:0"] {
        let board = Served::on(served);
        let link = board.link.to_string();
        let owner = armed(&terminals, &board, &link);
        assert_ends(
            &terminals.run(&["disarm"]),
            0,
            "disarmed by the program that has",
        );
        board.until_off();
        assert_eq!(board.seen().mode, Mode::Idle, "no fault");
        assert_ends(
            &owner.wait_with_output().unwrap(),
            2,
            "another program disarmed",
        );
    }
}

/// Where no socket can be made the program says so, and a stop that nothing was reached.
#[test]
fn a_folder_that_cannot_be_had_is_said_at_both_ends() {
    let terminals = Terminals::new("stop-no-folder");
    std::fs::remove_dir_all(terminals.sockets()).unwrap();
    std::fs::write(terminals.sockets(), "no folder").unwrap();
    let board = Served::on("pty:");
    let link = board.link.to_string();
    let owner = terminals.spawn(&["arm", "--for", "1", "--link", &link]);
    board.until("armed", |seen| seen.mode == Mode::Armed);
    assert_ends(&terminals.run(&["stop"]), 2, "NOTHING WAS STOPPED");
    let output = owner.wait_with_output().unwrap();
    assert_ends(
        &output,
        0,
        "`armbridge stop` from another terminal cannot reach",
    );
}

/// `arm` ends when the board reports nothing any more.
#[test]
fn a_board_that_falls_silent_ends_the_program() {
    use std::io::{BufRead, BufReader};

    let terminals = Terminals::new("silent-board");
    let mut server = terminals.spawn(&["serve", "board", "--listen", "pty:"]);
    let mut lines = BufReader::new(server.stderr.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    let link = line.split([' ', ';']).find(|word| word.starts_with("pty:"));
    let mut owner = terminals.spawn(&["arm", "--link", link.unwrap()]);
    let mut notes = BufReader::new(owner.stderr.take().unwrap()).lines();
    assert!(notes.next().unwrap().unwrap().contains("armed for 0 s"));
    signal(&server, "STOP");
    let output = owner.wait_with_output().unwrap();
    assert_ends(&output, 1, "MOTORS MAY BE ON");
    server.kill().unwrap();
    server.wait().unwrap();
}
