//! Viewers of `armbridge foxglove`: who may connect, who may command, and an arm that is
//! let go when its viewer leaves.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use armbridge_link::message::{Fault, Mode, StopSource};
use armbridge_tests::served_board::{Served, until};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use super::live::Live;

const TCP: &str = "tcp://127.0.0.1:0";
const PATIENCE: Duration = Duration::from_secs(20);
const STOPPED: Mode = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
/// Longer than a handshake, and than the silence of a connection.
const LONGER: Duration = Duration::from_secs(10);

fn address(live: &Live) -> SocketAddr {
    let rest = live.url.strip_prefix("ws://").unwrap();
    rest.split('/').next().unwrap().parse().unwrap()
}

fn connect(live: &Live) -> TcpStream {
    let stream = TcpStream::connect(address(live)).unwrap();
    stream.set_read_timeout(Some(LONGER)).unwrap();
    stream
}

/// A viewer.
pub(crate) struct Viewer {
    socket: WebSocket<TcpStream>,
    calls: u32,
}

impl Viewer {
    pub(crate) fn at(live: &Live, path: &str) -> Self {
        let url = format!("ws://{}{path}", address(live));
        let mut request = url.into_client_request().unwrap();
        let headers = request.headers_mut();
        headers.insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().unwrap());
        headers.insert("Origin", "https://app.foxglove.dev".parse().unwrap());
        let (socket, _) = tungstenite::client(request, connect(live)).unwrap();
        Self { socket, calls: 0 }
    }

    /// One that may command.
    fn with_token(live: &Live) -> Self {
        Self::at(
            live,
            live.url.split(&address(live).to_string()).nth(1).unwrap(),
        )
    }

    fn until<T>(&mut self, wanted: impl Fn(&Message) -> Option<T>) -> T {
        let begun = Instant::now();
        loop {
            assert!(begun.elapsed() < PATIENCE, "nothing of the kind came");
            if let Some(found) = wanted(&self.socket.read().unwrap()) {
                return found;
            }
        }
    }

    fn until_text(&mut self, op: &str) -> Value {
        self.until(|message| {
            let value: Value = serde_json::from_str(message.to_text().ok()?).ok()?;
            (value["op"] == op).then_some(value)
        })
    }

    /// Calls a service by its place in the list; the error, if it fails.
    pub(crate) fn call(&mut self, service: u32) -> Result<(), String> {
        self.calls += 1;
        let mut call = vec![2];
        for number in [service, self.calls, 4] {
            call.extend(number.to_le_bytes());
        }
        call.extend(b"json{}");
        self.socket.send(Message::binary(call)).unwrap();
        self.until(|message| match message {
            Message::Binary(bytes) if bytes[0] == 3 => Some(Ok(())),
            Message::Text(text) => {
                let value: Value = serde_json::from_str(text).unwrap();
                let error = value["message"].as_str().unwrap_or_default();
                (value["op"] == "serviceCallFailure").then(|| Err(error.into()))
            }
            _ => None,
        })
    }

    fn send(&mut self, message: &Value) {
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
    }
}

/// Places of services in the list.
pub(crate) const STOP: u32 = 0;
const DISARM: u32 = 1;
const CLEAR: u32 = 2;
const ARM: u32 = 3;
const HOLD: u32 = 4;

/// The first line of the answer to a request with these headers.
fn status(live: &Live, path: &str, headers: &str) -> String {
    let mut stream = connect(live);
    let request = format!(
        "GET {path} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n{headers}\r\n"
    );
    // A server may answer and close before it has read all of it.
    let _ = stream.write_all(request.as_bytes());
    first_line(&mut stream)
}

fn first_line(stream: &mut TcpStream) -> String {
    let mut bytes = Vec::new();
    while !bytes.ends_with(b"\n") {
        let mut byte = [0];
        match stream.read(&mut byte) {
            Ok(1) => bytes.push(byte[0]),
            _ => break,
        }
    }
    String::from_utf8(bytes).unwrap().trim().into()
}

#[test]
fn pages_of_other_sites_and_wrong_tokens_are_refused() {
    let live = Live::on("sim:", &["--allow-origin", "https://lab.example"]);
    let token = live.url.split_once("token=").unwrap().1;
    assert_eq!(token.len(), 32);
    let with_token = format!("/?token={token}");
    for (path, headers, answer) in [
        ("/", "", "101 Switching Protocols"),
        (&*with_token, "", "101 Switching Protocols"),
        (
            "/",
            "Origin: http://localhost:3000\r\n",
            "101 Switching Protocols",
        ),
        (
            "/",
            "Origin: https://lab.example\r\n",
            "101 Switching Protocols",
        ),
        ("/", "Origin: https://evil.example\r\n", "403 Forbidden"),
        // Even one that knows the token.
        (
            &*with_token,
            "Origin: https://evil.example\r\n",
            "403 Forbidden",
        ),
        ("/", "Origin: null\r\n", "403 Forbidden"),
        (
            "/?token=0123456789abcdef0123456789abcdef",
            "",
            "401 Unauthorized",
        ),
    ] {
        let status = status(&live, path, headers);
        assert_eq!(status, format!("HTTP/1.1 {answer}"), "{path} {headers}");
    }
    let long = format!("X: {}\r\n", "x".repeat(100_000));
    let too_long = status(&live, "/", &long);
    assert!(
        too_long.is_empty() || too_long.contains("431"),
        "{too_long}"
    );
}

#[test]
fn a_viewer_without_the_token_watches_and_stops() {
    let board = Served::on(TCP);
    let live = Live::on(&board.link.to_string(), &["--allow-arm"]);
    board.until("idle", |seen| seen.mode == Mode::Idle);
    let mut viewer = Viewer::at(&live, "/");
    viewer.send(&json!({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": 0}]}));
    viewer.until(|message| match message {
        Message::Binary(bytes) => bytes.starts_with(&[1, 7, 0, 0, 0]).then_some(()),
        _ => None,
    });
    // What a foreign page once changed.
    for (name, value) in [
        ("calibration.direction", json!(["reverse", "reverse"])),
        ("limits.silence_ms", json!(60_000)),
    ] {
        let wanted = json!([{"name": name, "value": value}]);
        viewer.send(&json!({"op": "setParameters", "parameters": wanted, "id": name}));
        let error = viewer.until_text("status");
        assert!(
            error["message"].as_str().unwrap().contains("token"),
            "{error}"
        );
        let values = viewer.until_text("parameterValues");
        assert_eq!(values["id"], name);
        assert_ne!(values["parameters"][0]["value"], value, "{values}");
    }
    for service in [ARM, HOLD, CLEAR] {
        let error = viewer.call(service).unwrap_err();
        assert!(
            error.contains("token") && error.contains("/stop"),
            "{error}"
        );
    }
    assert_eq!(board.seen().mode, Mode::Idle);
    assert_eq!(viewer.call(DISARM), Ok(()));
    let mut operator = Viewer::with_token(&live);
    assert_eq!(operator.call(HOLD), Ok(()));
    board.until("held", |seen| seen.mode.drive().is_some());
    assert_eq!(viewer.call(STOP), Ok(()));
    assert_eq!(board.seen().mode, STOPPED);
    board.until_off();
    assert!(viewer.call(CLEAR).is_err());
    assert_eq!(operator.call(CLEAR), Ok(()));
    board.until("cleared", |seen| seen.mode == Mode::Idle);
}

#[test]
fn an_arm_is_let_go_when_the_viewer_leaves_that_armed_it() {
    let board = Served::on(TCP);
    let live = Live::on(&board.link.to_string(), &["--allow-arm"]);
    let mut other = Viewer::at(&live, "/");
    // The operator leaves without a word, and in order; and no longer answers.
    for end in ["dropped", "closed", "mute"] {
        board.until("idle", |seen| seen.mode == Mode::Idle);
        let mut operator = Viewer::with_token(&live);
        // At first the board may still search for its servos.
        until("held", || operator.call(HOLD).is_ok());
        board.until("held", |seen| seen.mode.drive().is_some());
        let mut _mute = None;
        match end {
            "dropped" => drop(operator),
            "closed" => operator.socket.close(None).unwrap(),
            _ => _mute = Some(operator),
        }
        // The other one stays, and answers pings.
        until("motors are off", || {
            other.send(&json!({"op": "getParameters", "parameterNames": ["arm.l1_m"], "id": "x"}));
            other.until_text("parameterValues");
            !board.seen().mode.is_armed()
        });
        board.until_off();
        assert_eq!(board.seen().mode, Mode::Idle, "{end}: no fault");
    }
}

#[test]
fn half_open_connections_are_closed() {
    let live = Live::on("sim:", &[]);
    // More than handshakes at a time.
    let mut half_open: Vec<_> = (0..20).map(|_| connect(&live)).collect();
    for stream in &mut half_open {
        stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
    }
    let begun = Instant::now();
    let _viewer = Viewer::at(&live, "/");
    println!("a viewer waited {:?}", begun.elapsed());
    for stream in &mut half_open {
        let answer = first_line(stream);
        assert_eq!(answer, "HTTP/1.1 408 Request Timeout");
        assert!(matches!(
            stream.read_to_end(&mut Vec::new()),
            Ok(_) | Err(_)
        ));
    }
}

#[test]
fn viewers_without_the_token_give_way_and_none_keeps_an_operator_out() {
    let board = Served::on(TCP);
    let live = Live::on(&board.link.to_string(), &["--allow-arm"]);
    board.until("idle", |seen| seen.mode == Mode::Idle);
    let mut operator = Viewer::with_token(&live);
    until("held", || operator.call(HOLD).is_ok());
    // All places and more, each of which answers until it gives way.
    let mut crowd: Vec<_> = (0..20).map(|_| Viewer::at(&live, "/")).collect();
    let newest = crowd.last_mut().unwrap();
    newest.until_text("serverInfo");
    let mut second = Viewer::with_token(&live);
    second.until_text("serverInfo");
    assert!(board.seen().mode.is_armed(), "the operator has stayed");
    assert_eq!(Viewer::at(&live, "/").call(STOP), Ok(()));
    assert_eq!(board.seen().mode, STOPPED);
    assert_eq!(second.call(CLEAR), Ok(()));
    board.until("cleared", |seen| seen.mode == Mode::Idle);
    assert_eq!(operator.call(DISARM), Ok(()));
}
