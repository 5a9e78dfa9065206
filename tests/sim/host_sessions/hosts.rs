//! Hosts on links: one with an observer, one that gives up, one that panics, one that does
//! not read.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use armbridge_client::Host;
use armbridge_client::servo_bus::serial_device;
use armbridge_client::session::{BoardMessage, ChannelHost, CommandLink, Request};
use armbridge_client::transport::{LinkUri, drive};
use armbridge_link::message::{Command, Fault, Mode, ToHost};
use armbridge_tests::channel_host::{Manned, options};
use armbridge_tests::served_board::{Served, until};

#[test]
fn who_leaves_disarms() {
    let board = Served::on("tcp://127.0.0.1:0");
    let station = Manned::on(&board.link, Duration::ZERO);
    station.hold(&board);
    station.ask(Request::Leave);
    station.end().unwrap();
    board.until_off();
    assert_eq!(board.seen().mode, Mode::Idle, "no fault");
}

#[test]
fn when_the_controls_are_dropped_the_arm_is_disarmed() {
    let board = Served::on("tcp://127.0.0.1:0");
    let station = Manned::on(&board.link, Duration::ZERO);
    station.hold(&board);
    // As when the thread of a user interface panics.
    let Manned {
        controls, thread, ..
    } = station;
    drop(controls);
    thread.join().unwrap().unwrap();
    board.until_off();
    assert_eq!(board.seen().mode, Mode::Idle, "no fault");
}

/// A host that fails or panics on request.
///
/// It panics without the panic hook: a backtrace of this binary takes longer, on a machine
/// under load, than the silence after which a board faults.
struct Mortal {
    station: ChannelHost,
    end: Receiver<bool>,
}

impl Host for Mortal {
    type Error = String;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], String> {
        match self.end.try_recv() {
            Ok(true) => resume_unwind(Box::new("as requested")),
            Ok(false) => Err("as requested".into()),
            Err(_) => self
                .station
                .transmit(now_us)
                .map_err(|error| error.to_string()),
        }
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), String> {
        let result = self.station.receive(now_us, bytes);
        result.map_err(|error| error.to_string())
    }

    fn wake_at_us(&self) -> u64 {
        self.station.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.station.is_done()
    }
}

#[test]
fn a_host_that_gives_up_or_panics_says_goodbye() {
    for panics in [false, true] {
        let board = Served::on("tcp://127.0.0.1:0");
        let (end, is_end) = channel();
        let (station, controls) = ChannelHost::new();
        let link = board.link.clone();
        let thread = std::thread::spawn(move || {
            let mortal = Mortal {
                station,
                end: is_end,
            };
            drive(&link, options(Duration::ZERO), mortal).1.is_err()
        });
        board.until("idle", |seen| seen.mode == Mode::Idle);
        controls.request(Request::Arm).unwrap();
        let hold = Command::Regulate([0.0; 2]);
        controls.request(Request::Command(hold)).unwrap();
        board.until("motors are on", |seen| seen.mode.drive().is_some());
        end.send(panics).unwrap();
        assert_eq!(thread.join().is_err(), panics);
        board.until_off();
        assert_eq!(board.seen().mode, Mode::Idle, "no fault: it was disarmed");
    }
}

/// Over a pseudo-terminal, which buffers little.
#[cfg(unix)]
#[test]
fn a_host_that_does_not_read_holds_up_nothing() {
    use armbridge_client::servo_bus::Line;

    let board = Served::on("pty:");
    let LinkUri::Pty(Some(path)) = &board.link else {
        panic!("{}", board.link);
    };
    let mut line = serial_device::open(path, 1_000_000).unwrap();
    let mut client = CommandLink::default();
    let begun = Instant::now();
    let now_us = || begun.elapsed().as_micros() as u64;
    let (mut session, mut is_armed) = (None, false);
    // Sends hello, arms, holds the arm.
    until("armed", || {
        line.send(client.transmit(now_us())).unwrap();
        let bytes = line.receive(Instant::now() + Duration::from_millis(10));
        let mut wish = None;
        let bytes = bytes.unwrap();
        let mut bytes = bytes.as_slice();
        while let Some(message) = client.receive(&mut bytes) {
            match message {
                BoardMessage::Other(ToHost::Board(report)) => session = Some(report.session),
                BoardMessage::Other(ToHost::Record(record)) if record.mode == Mode::Idle => {
                    wish = session.map(|session| Command::Arm { session });
                }
                BoardMessage::Done => is_armed = true,
                _ => {}
            }
        }
        if let (Some(arm), true) = (wish, client.is_settled()) {
            client.command(arm);
        }
        is_armed
    });
    client.command(Command::Regulate([0.0; 2]));
    line.send(client.transmit(now_us())).unwrap();
    // And then neither reads nor speaks.
    let silent = Mode::Fault(Fault::HostSilent);
    board.until("the host is found silent", |seen| seen.mode == silent);
    board.until_off();
    // The board goes on sending; what is not read is lost in whole frames.
    std::thread::sleep(Duration::from_secs(2));
    let (mut mode, mut damaged) = (None, 0);
    until("the board is heard again", || {
        line.send(client.transmit(now_us())).unwrap();
        let bytes = line.receive(Instant::now() + Duration::from_millis(10));
        let bytes = bytes.unwrap();
        let mut bytes = bytes.as_slice();
        while let Some(message) = client.receive(&mut bytes) {
            if let BoardMessage::Other(ToHost::Record(record)) = message {
                mode = Some(record.mode);
            }
        }
        damaged = client.stats().damaged;
        mode == Some(silent) && client.stats().lost > 0
    });
    assert_eq!(damaged, 0, "no half frames");
}
