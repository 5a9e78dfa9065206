//! Listeners: floods of bytes, silence, and the network.
//!
//! A flood is as much as the listener takes in two seconds, of bytes that are no frame: memory
//! stays within bounds, and the board goes on.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use armbridge_client::session::Request;
use armbridge_client::transport::LinkUri;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{self, Fault, Mode, StopSource, ToBoard};
use armbridge_link::schema;
use armbridge_tests::channel_host::Manned;
use armbridge_tests::served_board::{Served, until};

use super::live::Live;
use super::viewers::{STOP, Viewer};

const FLOOD: Duration = Duration::from_secs(2);
const GROWTH_MAX_KB: u64 = 50_000;
/// Connections that flood at a time.
const FLOODS: usize = 3;
const STOPPED: Mode = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
/// Longest time from a stop to torque off, by the board's clock.
const STOP_US: u64 = 100_000;

/// `armbridge serve`, ended with the test.
pub(crate) struct Program {
    child: Child,
    pub(crate) at: String,
}

impl Program {
    pub(crate) fn serve(args: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .arg("serve")
            .args(args)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
        let (_, rest) = line.split_once("tcp://").expect(&line);
        let at = rest.split([',', ';']).next().unwrap().trim().to_owned();
        Self { child, at }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Memory of a process in use, in kB.
fn memory_kb(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmRSS:"))
        .unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

/// Sends as many of `bytes` as the listener takes; returns their number.
fn flood(at: &str, first: &[u8], bytes: &[u8]) -> u64 {
    let begun = Instant::now();
    let mut sent = 0;
    while begun.elapsed() < FLOOD {
        // A listener may close the connection; the flood goes on with another one.
        let Ok(mut stream) = TcpStream::connect(at) else {
            continue;
        };
        stream
            .set_write_timeout(Some(Duration::from_millis(100)))
            .unwrap();
        let _ = stream.write_all(first);
        while begun.elapsed() < FLOOD {
            match stream.write(bytes) {
                Ok(count) => sent += count as u64,
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                Err(_) => break,
            }
        }
    }
    sent
}

/// Floods a listener from several connections at once, in which memory does not grow.
fn assert_bounded(at: &str, process: u32, first: &[u8], bytes: &'static [u8]) {
    let before = memory_kb(process);
    let floods: Vec<_> = (0..FLOODS)
        .map(|_| {
            let (at, first) = (at.to_owned(), first.to_vec());
            std::thread::spawn(move || flood(&at, &first, bytes))
        })
        .collect();
    let mut most = before;
    while floods.iter().any(|flood| !flood.is_finished()) {
        most = most.max(memory_kb(process));
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent: u64 = floods.into_iter().map(|flood| flood.join().unwrap()).sum();
    let grown = most - before;
    println!(
        "{} kB sent to {at}: {grown} kB of memory more",
        sent / 1_000
    );
    assert!(sent > 100_000 && grown < GROWTH_MAX_KB, "{grown} kB");
}

/// No frame, and no end of one.
static GARBAGE: [u8; 65_536] = [7; 65_536];
/// Heads of packets on the bus of stock servos.
static HEADS: [u8; 65_536] = [0xFF; 65_536];
/// Empty pings of a WebSocket.
static PINGS: LazyLock<Vec<u8>> = LazyLock::new(|| [0x89, 0x80, 0, 0, 0, 0].repeat(10_922));

#[test]
fn a_flooded_link_has_bounds_and_the_board_goes_on() {
    let server = Program::serve(&["board", "--link", "sim:", "--listen", "tcp://127.0.0.1:0"]);
    let link: LinkUri = format!("tcp://{}", server.at).parse().unwrap();
    let host = Manned::on(&link, Duration::ZERO);
    until("idle", || host.received().mode == Some(Mode::Idle));
    host.ask(Request::Arm);
    host.ask(Request::Command(message::Command::Regulate([0.0; 2])));
    let hello = Encoder::default()
        .encode(&ToBoard::Hello(schema::HELLO))
        .1
        .to_vec();
    // Of newcomers, and of watchers.
    for first in [&[][..], &hello] {
        let before = host.received();
        assert_bounded(&server.at, server.child.id(), first, &GARBAGE);
        until("the board answers", || {
            host.received().records > before.records + 100
        });
        let after = host.received();
        assert!(after.mode.is_some_and(Mode::is_armed), "{:?}", after.mode);
    }
    // A stop in the midst of it.
    let at = server.at.clone();
    let flooding = std::thread::spawn(move || flood(&at, &[], &GARBAGE));
    std::thread::sleep(FLOOD / 4);
    let sent_us = host.received().board_us;
    let stop = Encoder::default().encode(&ToBoard::Stop).1.to_vec();
    let mut other = TcpStream::connect(&server.at).unwrap();
    other.write_all(&stop).unwrap();
    until("stopped", || host.received().mode == Some(STOPPED));
    let took_us = host.received().stopped_us - sent_us;
    println!("stopped after {took_us} us in a flood");
    assert!(took_us < STOP_US, "{took_us} us");
    flooding.join().unwrap();
}

/// Garbage of the host that commands is an emergency stop, as on a real link.
#[test]
fn a_flood_of_the_commander_is_a_stop() {
    let board = Served::on("tcp://127.0.0.1:0");
    board.until("idle", |seen| seen.mode == Mode::Idle);
    let at = board.link.to_string();
    let mut stream = TcpStream::connect(at.strip_prefix("tcp://").unwrap()).unwrap();
    let hello = Encoder::default()
        .encode(&ToBoard::Hello(schema::HELLO))
        .1
        .to_vec();
    stream.write_all(&hello).unwrap();
    stream.write_all(&GARBAGE[..16_384]).unwrap();
    let flooded = Mode::Fault(Fault::EmergencyStop(StopSource::Flood));
    board.until("stopped", |seen| seen.mode == flooded);
}

/// Servers of raw bytes: a bus of servos, and a board's transparent port.
const BUS_SERVERS: [&[&str]; 2] = [
    &["servos", "--listen", "tcp://127.0.0.1:0"],
    &[
        "board",
        "--link",
        "sim:",
        "--transparent",
        "tcp://127.0.0.1:0",
    ],
];

#[test]
fn a_flooded_bus_or_transparent_port_has_bounds() {
    for args in BUS_SERVERS {
        let server = Program::serve(args);
        assert_bounded(&server.at, server.child.id(), &[], &HEADS);
        assert_bounded(&server.at, server.child.id(), &[], &GARBAGE);
    }
}

/// A connection that says nothing keeps a bus or a port only until another one comes.
#[test]
fn a_silent_connection_gives_way() {
    const PING: [u8; 6] = [0xAA, 3, 1, 0xFE, 1, 0xF9];
    for args in BUS_SERVERS {
        let server = Program::serve(args);
        let mut silent = TcpStream::connect(&server.at).unwrap();
        std::thread::sleep(Duration::from_millis(100));
        let mut next = TcpStream::connect(&server.at).unwrap();
        next.set_read_timeout(Some(Duration::from_millis(200)))
            .unwrap();
        until("the next one is answered", || {
            next.write_all(&PING).unwrap();
            matches!(next.read(&mut [0; 64]), Ok(1..))
        });
        silent.set_read_timeout(Some(FLOOD)).unwrap();
        let closed = silent.read(&mut [0; 64]);
        assert!(matches!(closed, Ok(0)), "{args:?}: {closed:?}");
    }
}

#[test]
fn a_listener_is_exposed_to_the_network_only_on_request() {
    let any = "tcp://0.0.0.0:0";
    for args in [
        ["serve", "board", "--link", "sim:", "--listen", any].as_slice(),
        &["serve", "board", "--link", "sim:", "--transparent", any],
        &["serve", "servos", "--listen", any],
        &["run", "--duration", "1", "--transparent", any],
        &[
            "foxglove", "--link", "sim:", "--host", "0.0.0.0", "--port", "0",
        ],
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        let output = command.args(args).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("--expose") && error.contains("any host of the network"));
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let exposed = Program::serve(&["servos", "--listen", any, "--expose"]);
    assert!(exposed.at.starts_with("0.0.0.0:"));
}

#[test]
fn a_flooded_viewers_port_has_bounds_and_the_board_goes_on() {
    let board = Served::on("tcp://127.0.0.1:0");
    let live = Live::on(&board.link.to_string(), &[]);
    board.until("idle", |seen| seen.mode == Mode::Idle);
    let at = live.url.strip_prefix("ws://").unwrap();
    let at = at.split('/').next().unwrap();
    let upgrade = b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n\
        Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
        Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
    // In the handshake; as pings, which are answered; and as a message without end.
    let endless = [
        upgrade.as_slice(),
        &[0x01, 0xFF, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 3, 4],
    ]
    .concat();
    assert_bounded(at, live.id(), &[], &GARBAGE);
    assert_bounded(at, live.id(), upgrade, &PINGS);
    assert_bounded(at, live.id(), &endless, &GARBAGE);
    // The next viewer is served, and stops the board.
    assert_eq!(Viewer::at(&live, "/").call(STOP), Ok(()));
    assert_eq!(board.seen().mode, STOPPED);
}
