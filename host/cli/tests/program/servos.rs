//! `armbridge serve servos` as another program meets it: raw bus bytes over TCP and
//! over a pseudo-terminal, in wall-clock time.
//!
//! No time is asserted, only bytes; a busy machine may delay a packet
//! so that a servo misses the next, so requests are repeated.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

const PING_1: [u8; 6] = [0xAA, 3, 1, 0xFE, 1, 0xF9];
const PONG_1: [u8; 6] = [0xAA, 3, 0xFE, 1, 1, 0xF9];
const PONG_2: [u8; 6] = [0xAA, 3, 0xFE, 2, 1, 0xF8];
const STOCK_PING_1: [u8; 6] = [0xFF, 0xFF, 1, 2, 1, 0xFB];
const STOCK_PONG_1: [u8; 6] = [0xFF, 0xFF, 1, 2, 0, 0xFC];
const START: [u8; 6] = [0xAA, 3, 0xFF, 0xFE, 6, 0xF6];
const CYCLE: [u8; 6] = [0xAA, 3, 0xFF, 0xFE, 7, 0xF5];

/// Longest time that a busy machine may take to answer.
const PATIENCE: Duration = Duration::from_secs(20);
/// Silence after which nothing more is coming.
const SILENCE: Duration = Duration::from_millis(300);
/// More than the time in which a stock servo receives nothing after an EEPROM byte.
const DEAF: Duration = Duration::from_millis(50);
const ATTEMPTS: usize = 20;

/// The program, ended with the test.
struct Servos(Child);

impl Servos {
    fn start(args: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        command.args(["serve", "servos"]).args(args);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().unwrap())
    }

    /// Serving on a free port; returns where.
    fn on_tcp(args: &[&str]) -> (Self, String) {
        let mut servos = Self::start(&[&["--listen", "tcp://127.0.0.1:0"], args].concat());
        let mut stderr = BufReader::new(servos.0.stderr.take().unwrap());
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        // Its other lines are of no interest, but must go somewhere.
        std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
        let (_, at) = line.split_once("tcp://").expect(&line);
        let (at, _) = at.split_once(',').expect(&line);
        (servos, at.to_owned())
    }
}

impl Drop for Servos {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Our end of the bus.
struct Bus<W> {
    to: W,
    from: Receiver<Vec<u8>>,
}

impl<W: Write> Bus<W> {
    fn new(to: W, mut from: impl Read + Send + 'static) -> Self {
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            let mut bytes = [0; 256];
            while let Ok(count @ 1..) = from.read(&mut bytes) {
                if sender.send(bytes[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self { to, from: receiver }
    }

    /// The reply to `request`: as many bytes as are wanted, or fewer if silence follows.
    fn ask(&mut self, request: &[u8], wanted: usize) -> Vec<u8> {
        self.to.write_all(request).unwrap();
        let mut reply = Vec::new();
        let mut patience = PATIENCE;
        while reply.len() < wanted {
            match self.from.recv_timeout(patience) {
                Ok(bytes) => reply.extend(bytes),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => panic!("the servos are gone"),
            }
            patience = SILENCE;
        }
        reply
    }

    /// The answer to `request` that is as it should be.
    fn expect(&mut self, request: &[u8], wanted: usize, is_right: impl Fn(&[u8]) -> bool) {
        let mut reply = Vec::new();
        for _ in 0..ATTEMPTS {
            reply = self.ask(request, wanted);
            if is_right(&reply) {
                return;
            }
            // A late reply belongs to this attempt.
            while self.from.recv_timeout(SILENCE).is_ok() {}
        }
        panic!("asked {request:02x?}, heard {reply:02x?} at last");
    }
}

/// Whether these are positions of servos 1 and 2, in this order, of an arm
/// held at 0.1 and -0.1 rad: 20 counts from 512, and noise.
fn are_positions(reply: &[u8]) -> bool {
    let position = |packet: &[u8], id: u8| match *packet {
        [0xAA, 4, 0xFE, from, high, low, _] if from == id => {
            let crc = packet[1..6]
                .iter()
                .fold(0_u8, |sum, byte| sum.wrapping_add(!byte));
            (crc == packet[6]).then(|| u16::from_be_bytes([high, low]))
        }
        _ => None,
    };
    let Some((first, second)) = reply.split_at_checked(7) else {
        return false;
    };
    position(first, 1).is_some_and(|counts| (529..=534).contains(&counts))
        && position(second, 2).is_some_and(|counts| (490..=495).contains(&counts))
}

fn connect(at: &str) -> TcpStream {
    let stream = TcpStream::connect(at).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

#[test]
fn over_tcp() {
    let (_servos, at) = Servos::on_tcp(&["--initial", "0.1,-0.1"]);
    let stream = connect(&at);
    let mut bus = Bus::new(stream.try_clone().unwrap(), stream.try_clone().unwrap());
    bus.expect(&PING_1, 6, |reply| reply == PONG_1);
    bus.expect(&START, 12, |reply| reply == [PONG_1, PONG_2].concat());
    bus.expect(&CYCLE, 14, are_positions);
    stream.shutdown(Shutdown::Both).unwrap();
    drop(bus);

    // Who comes next finds them started, and who hangs up after asking is
    // answered all the same.
    let stream = connect(&at);
    let mut bus = Bus::new(stream.try_clone().unwrap(), stream.try_clone().unwrap());
    bus.expect(&CYCLE, 14, are_positions);
    drop(bus);
    stream.shutdown(Shutdown::Both).unwrap();
    let mut stream = connect(&at);
    stream.write_all(&PING_1).unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut reply = Vec::new();
    stream.read_to_end(&mut reply).unwrap();
    assert_eq!(reply, PONG_1);
}

#[test]
fn a_bus_that_hears_itself() {
    let (_servos, at) = Servos::on_tcp(&["--echo"]);
    let stream = connect(&at);
    let mut bus = Bus::new(stream.try_clone().unwrap(), stream);
    bus.expect(&PING_1, 12, |reply| reply == [PING_1, PONG_1].concat());
}

#[test]
fn stock_servos_at_a_rate_of_their_own() {
    let (_servos, at) = Servos::on_tcp(&[
        "--firmware",
        "stock,morpheus,stock",
        "--ids",
        "1,1,0",
        "--servo-baud",
        "57600",
        "--baud",
        "57600",
    ]);
    let stream = connect(&at);
    let mut bus = Bus::new(stream.try_clone().unwrap(), stream);
    bus.expect(&STOCK_PING_1, 6, |reply| reply == STOCK_PONG_1);
    bus.expect(&PING_1, 6, |reply| reply == PONG_1);
    let [ping_0, pong_0] = [[0xFF, 0xFF, 0, 2, 1, 0xFC], [0xFF, 0xFF, 0, 2, 0, 0xFD]];
    bus.expect(&ping_0, 6, |reply| reply == pong_0);
}

/// The terminal on which they are.
#[cfg(unix)]
fn on_pty(args: &[&str]) -> (Servos, std::fs::File) {
    let mut servos = Servos::start(&[&["--listen", "pty:"], args].concat());
    let mut name = String::new();
    let mut stdout = BufReader::new(servos.0.stdout.take().unwrap());
    stdout.read_line(&mut name).unwrap();
    let mut options = std::fs::OpenOptions::new();
    let port = options.read(true).write(true).open(name.trim()).unwrap();
    (servos, port)
}

#[test]
#[cfg(unix)]
fn the_rate_of_a_pseudo_terminal_is_that_of_the_bus() {
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

    let (_servos, port) = on_pty(&["--firmware", "stock"]);
    let set_baud = |baud| {
        let mut terminal = tcgetattr(&port).unwrap();
        terminal.set_speed(baud).unwrap();
        tcsetattr(&port, OptionalActions::Now, &terminal).unwrap();
    };
    let mut bus = Bus::new(port.try_clone().unwrap(), port.try_clone().unwrap());
    bus.expect(&STOCK_PING_1, 6, |reply| reply == STOCK_PONG_1);
    set_baud(57_600);
    bus.expect(&STOCK_PING_1, 0, <[u8]>::is_empty);
    assert!(bus.from.recv_timeout(SILENCE).is_err());
    set_baud(1_000_000);
    // The servo takes 57600 baud from after its answer on.
    let to_57600 = [0xFF, 0xFF, 1, 4, 3, 4, 34, 0xD1];
    bus.expect(&to_57600, 6, |reply| reply == STOCK_PONG_1);
    std::thread::sleep(DEAF);
    set_baud(57_600);
    bus.expect(&STOCK_PING_1, 6, |reply| reply == STOCK_PONG_1);
}

#[test]
#[cfg(unix)]
fn over_a_pseudo_terminal() {
    let (_servos, port) = on_pty(&["--initial", "0.1,-0.1"]);
    let mut bus = Bus::new(port.try_clone().unwrap(), port);
    bus.expect(&PING_1, 6, |reply| reply == PONG_1);
    bus.expect(&START, 12, |reply| reply == [PONG_1, PONG_2].concat());
    bus.expect(&CYCLE, 14, are_positions);
}
