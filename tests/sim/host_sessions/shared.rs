//! Several connections on one link: one commands, the others watch, each may stop.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use armbridge_client::session::{BoardMessage, CommandLink, Request};
use armbridge_link::frame::{Decoder, Encoder};
use armbridge_link::message::{Command, Fault, Mode, Refusal, StopSource, ToBoard, ToHost};
use armbridge_link::schema;
use armbridge_link::server::{FromServer, LinkRole, Program, ToServer, Touch};
use armbridge_tests::channel_host::Manned;
use armbridge_tests::served_board::{Served, until};

const TCP: &str = "tcp://127.0.0.1:0";
const STOPPED: Mode = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
/// Longest time from a stop to torque off, in simulated µs.
const STOP_US: u64 = 100_000;

/// A connection that does nothing by itself.
fn connect(board: &Served) -> TcpStream {
    let at = board.link.to_string();
    let stream = TcpStream::connect(at.strip_prefix("tcp://").unwrap()).unwrap();
    let timeout = Duration::from_millis(5);
    stream.set_read_timeout(Some(timeout)).unwrap();
    stream
}

/// Whether the server has closed it, with all that was sent before.
fn is_closed(mut stream: &TcpStream) -> bool {
    let mut chunk = [0; 4096];
    match stream.read(&mut chunk) {
        Ok(count) => count == 0,
        Err(error) => error.kind() == std::io::ErrorKind::ConnectionReset,
    }
}

/// A hand-driven host on a connection.
struct ByHand {
    stream: TcpStream,
    link: CommandLink,
    begun: Instant,
    /// Of messages of the server.
    notices: Decoder,
    role: Option<LinkRole>,
}

impl ByHand {
    fn on(board: &Served) -> Self {
        Self {
            stream: connect(board),
            link: CommandLink::default(),
            begun: Instant::now(),
            notices: Decoder::default(),
            role: None,
        }
    }

    /// The same, of a program that has announced itself.
    fn joined(board: &Served, name: &str, is_observer: bool) -> Self {
        let mut host = Self::on(board);
        let join = ToServer::Join {
            is_observer,
            program: Program::new(name, 7),
        };
        let frame = Encoder::default().encode(&join).1.to_vec();
        host.stream.write_all(&frame).unwrap();
        host
    }

    fn is_watching(&self) -> bool {
        self.role.is_some_and(|role| !role.is_commander)
    }

    /// Sends what is due, and takes what has come.
    fn messages(&mut self) -> Vec<BoardMessage> {
        // A clock that ran ahead would repeat the hello before it can be answered.
        let now_us = self.begun.elapsed().as_micros() as u64;
        let due = self.link.transmit(now_us).to_vec();
        self.stream.write_all(&due).unwrap();
        let mut chunk = vec![0; 65_536];
        let count = self.stream.read(&mut chunk).unwrap_or(0);
        let mut bytes = &chunk[..count];
        for byte in bytes {
            if let Some(Ok(received)) = self.notices.push::<FromServer>(*byte)
                && let FromServer::Role(role) = received.message
            {
                self.role = Some(role);
            }
        }
        std::iter::from_fn(|| self.link.receive(&mut bytes)).collect()
    }

    fn until(&mut self, condition: &str, mut is_it: impl FnMut(&BoardMessage) -> bool) {
        until(condition, || self.messages().iter().any(&mut is_it));
    }
}

#[test]
fn others_watch_and_only_one_commands() {
    let board = Served::on(TCP);
    let first = Manned::on(&board.link, Duration::ZERO);
    first.hold(&board);
    let mut second = ByHand::on(&board);
    let mut told = Vec::new();
    second.until("a record", |message| {
        told.push(*message);
        matches!(message, BoardMessage::Other(ToHost::Record(record)) if record.mode.is_armed())
    });
    assert!(second.is_watching());
    // As the board itself answers a hello.
    let is_told = |is_it: fn(&BoardMessage) -> bool| told.iter().any(is_it);
    assert!(is_told(|message| matches!(message, BoardMessage::Hello(_))));
    assert!(is_told(|message| matches!(
        message,
        BoardMessage::Other(ToHost::Board(_))
    )));
    assert!(is_told(|message| matches!(
        message,
        BoardMessage::Other(ToHost::Settings(_))
    )));
    assert!(is_told(|message| matches!(
        message,
        BoardMessage::Other(ToHost::Found { .. })
    )));
    for command in [Command::Idle, Command::Torque([0.1; 2]), Command::Save] {
        second.link.command(command);
        second.until("a refusal", |message| {
            assert_ne!(*message, BoardMessage::Done, "{command:?}");
            *message == BoardMessage::Refused(Refusal::OtherSession)
        });
    }
    let goodbye = second.link.goodbye().to_vec();
    second.stream.write_all(&goodbye).unwrap();
    let before = first.received().records;
    until("records go on", || first.received().records > before + 100);
    assert!(board.seen().mode.drive().is_some(), "still held");
    assert_eq!(first.received().lost, 0);

    // The link goes to the next hello.
    first.ask(Request::Leave);
    first.end().unwrap();
    let mut third = ByHand::on(&board);
    third.until("greeted", |message| {
        matches!(message, BoardMessage::Hello(_))
    });
    third.link.command(Command::Idle);
    third.until("done", |message| *message == BoardMessage::Done);
    assert!(!third.is_watching());
}

#[test]
fn an_observer_never_commands_and_knows_who_does() {
    let board = Served::on(TCP);
    let mut observer = ByHand::joined(&board, "observer", true);
    // Its hello opens no session of its own, but it sees the idle board.
    observer.until("a record", |message| {
        matches!(message, BoardMessage::Other(ToHost::Record(record)) if record.mode == Mode::Idle)
    });
    let uncommanded = LinkRole {
        is_commander: false,
        commander: None,
        is_touchable: true,
    };
    assert_eq!(observer.role, Some(uncommanded));
    observer.link.command(Command::Arm { session: 1 });
    observer.until("a refusal", |message| {
        *message == BoardMessage::Refused(Refusal::OtherSession)
    });
    let mut commander = ByHand::joined(&board, "commander", false);
    commander.until("greeted", |message| {
        matches!(message, BoardMessage::Hello(_))
    });
    let named = Some(Program::new("commander", 7));
    until("both know", || {
        let _ = (observer.messages(), commander.messages());
        [&observer, &commander].map(|host| host.role.unwrap().commander) == [named; 2]
    });
    assert!(!commander.is_watching() && observer.is_watching());
    // What is for the server does not reach the board, also from the commander.
    commander.link.command(Command::Idle);
    let touch = ToServer::Touch(Touch::Lift);
    let frame = Encoder::default().encode(&touch).1.to_vec();
    for _ in 0..200 {
        commander.stream.write_all(&frame).unwrap();
    }
    commander.until("done", |message| *message == BoardMessage::Done);
    let goodbye = commander.link.goodbye().to_vec();
    commander.stream.write_all(&goodbye).unwrap();
    observer.until("records go on", |message| {
        matches!(message, BoardMessage::Other(ToHost::Record(_)))
    });
    until("nobody commands", || {
        observer.messages();
        observer.role == Some(uncommanded)
    });
    assert_eq!(board.seen().mode, Mode::Idle);
}

#[test]
fn anyone_stops_within_100_ms() {
    let stop = Encoder::default().encode(&ToBoard::Stop).1.to_vec();
    // Without a hello; and behind one.
    for with_hello in [false, true] {
        let board = Served::on(TCP);
        let first = Manned::on(&board.link, Duration::ZERO);
        first.hold(&board);
        let mut encoder = Encoder::default();
        let hello = encoder.encode(&ToBoard::Hello(schema::HELLO)).1.to_vec();
        let mut other = connect(&board);
        if with_hello {
            other.write_all(&hello).unwrap();
        }
        let sent_us = board.seen().now_us;
        other.write_all(&stop).unwrap();
        board.until("stopped", |seen| seen.mode == STOPPED);
        let took_us = board.seen().now_us - sent_us;
        println!("stopped after {took_us} us, hello: {with_hello}");
        assert!(took_us < STOP_US, "{took_us} us");
        board.until_off();
        until("the commander knows", || {
            first.received().mode == Some(STOPPED)
        });
    }
}

/// In the middle of a frame of the commander, whose rest must not hide the stop.
#[test]
fn a_stop_cuts_into_a_frame() {
    let board = Served::on(TCP);
    let mut first = ByHand::on(&board);
    first.until("greeted", |message| {
        matches!(message, BoardMessage::Hello(_))
    });
    first.stream.write_all(&[1, 2, 3]).unwrap();
    let stop = Encoder::default().encode(&ToBoard::Stop).1.to_vec();
    std::thread::sleep(Duration::from_millis(20));
    // Empty frames before it are none of its bytes.
    let stop = [&[0; 1_000], stop.as_slice()].concat();
    connect(&board).write_all(&stop).unwrap();
    board.until("stopped", |seen| seen.mode == STOPPED);
}

#[test]
fn a_silent_connection_owns_nothing_and_is_closed() {
    let board = Served::on(TCP);
    let silent = connect(&board);
    let mut garbage = connect(&board);
    garbage.write_all(&[7; 300]).unwrap();
    // Heartbeats without a hello are no host either.
    let mut mute = connect(&board);
    let heartbeat = Encoder::default().encode(&ToBoard::Heartbeat).1.to_vec();
    mute.write_all(&heartbeat).unwrap();
    let host = Manned::on(&board.link, Duration::ZERO);
    host.hold(&board);
    for stream in [&silent, &garbage, &mute] {
        until("closed", || is_closed(stream));
    }
    assert!(board.seen().mode.drive().is_some(), "still held");
}

/// A page in a browser can send a request with frames in its body to any port.
#[test]
fn a_request_of_a_browser_commands_nothing() {
    let board = Served::on(TCP);
    board.until("idle", |seen| seen.mode == Mode::Idle);
    let mut encoder = Encoder::default();
    let mut body = vec![0];
    let words = [
        ToBoard::Hello(schema::HELLO),
        ToBoard::Command(Command::Arm { session: 2 }),
        ToBoard::Stop,
    ];
    for word in words {
        body.extend_from_slice(encoder.encode(&word).1);
    }
    let head = b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".as_slice();
    let mut page = connect(&board);
    page.write_all(&[head, &body].concat()).unwrap();
    until("closed", || is_closed(&page));
    assert_eq!(board.seen().mode, Mode::Idle);
    // The same without the head arms, and stops.
    connect(&board).write_all(&body).unwrap();
    board.until("stopped", |seen| seen.mode == STOPPED);
}

/// More connections than there are places: the last one still stops.
#[test]
fn a_crowd_does_not_keep_a_stop_out() {
    let board = Served::on(TCP);
    let first = Manned::on(&board.link, Duration::ZERO);
    first.hold(&board);
    let crowd: Vec<ByHand> = (0..40)
        .map(|_| {
            let mut one = ByHand::on(&board);
            one.messages();
            one
        })
        .collect();
    let mut last = connect(&board);
    let stop = Encoder::default().encode(&ToBoard::Stop).1.to_vec();
    last.write_all(&stop).unwrap();
    board.until("stopped", |seen| seen.mode == STOPPED);
    let received = first.received();
    assert_eq!((received.lost, received.partings), (0, 0));
    drop(crowd);
}
