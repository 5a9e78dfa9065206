//! `armbridge stop` while another program has the link.

use std::time::Duration;

use armbridge_client::Host;
use armbridge_client::session::{ChannelHost, Request};
use armbridge_client::transport::stop_socket::{self, StopAnswer};
use armbridge_client::transport::{LinkUri, drive};
use armbridge_shared::link::message::{Command, Drive, Fault, Mode, StopSource};
use armbridge_tests::channel_host::{Manned, options};
use armbridge_tests::served_board::Served;

use super::program::{assert_ends, run, spawn};

const STOPPED: Mode = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
/// Longest time from a request to torque off, in simulated µs.
const STOP_US: u64 = 100_000;

/// The owner's answer, once its socket is there.
fn ask(link: &LinkUri) -> StopAnswer {
    let mut answer = None;
    armbridge_tests::served_board::until("the socket is there", || {
        answer = stop_socket::ask(link);
        answer.is_some()
    });
    answer.unwrap()
}

fn stopped() -> StopAnswer {
    StopAnswer::Stopped("emergency_stop_host".into())
}

#[test]
fn a_second_terminal_stops_within_100_ms() {
    let board = Served::on("pty:");
    let owner = Manned::on(&board.link, Duration::ZERO);
    owner.hold(&board);
    let asked_us = board.seen().now_us;
    assert_eq!(ask(&board.link), stopped());
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
        let by_owner = "stopped by the program that has pty:///dev/pts/";
        assert_ends(&output, 0, by_owner);
        assert_ends(&output, 0, "the board reports emergency_stop_host");
        board.until_off();
        assert_ends(&owner.wait_with_output().unwrap(), code, words);
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
    assert_eq!(ask(&board.link), stopped());
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
        assert_eq!(stop_socket::ask(&board.link), None);
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
    assert_eq!(ask(&board.link), stopped());
}

#[test]
fn where_nothing_can_be_stopped_the_error_says_what_else_to_do() {
    for link in ["tcp://127.0.0.1:9", "pty:///dev/no-such-device"] {
        assert_ends(
            &run(&link, &["stop"]),
            2,
            "nothing was stopped: use the stop switch",
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
