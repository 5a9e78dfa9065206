//! `armbridge serve board --json`: programs that speak JSON, good and bad.

mod clients;

use std::io::{BufRead, BufReader, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use armbridge_tests::served_board::Served;
use serde_json::{Value, json};

use crate::listeners::Program;

/// Longest wait for an answer, and for the arm to be let go of.
const WAIT: Duration = Duration::from_secs(20);

/// A program that is connected.
struct Client {
    lines: BufReader<TcpStream>,
}

impl Client {
    fn of(server: &Program) -> Self {
        let stream = TcpStream::connect(&server.at).unwrap();
        stream.set_read_timeout(Some(WAIT)).unwrap();
        stream.set_nodelay(true).unwrap();
        Self {
            lines: BufReader::new(stream),
        }
    }

    fn send(&mut self, text: &str) {
        self.lines.get_mut().write_all(text.as_bytes()).unwrap();
    }

    fn receive(&mut self) -> Value {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"))
    }

    /// Makes a request. Returns its answer.
    fn ask(&mut self, request: &Value) -> Value {
        self.send(&format!("{request}\n"));
        self.receive()
    }

    fn done(&mut self, request: &Value) -> Value {
        let answer = self.ask(request);
        assert_eq!(answer["ok"], true, "{request}: {answer}");
        answer
    }

    fn fails(&mut self, request: &Value, kind: &str, text: &str) {
        let answer = self.ask(request);
        let why = answer["text"].as_str().unwrap_or_default();
        assert!(
            answer["error"] == kind && why.contains(text),
            "{request}: {answer}"
        );
    }

    fn mode(&mut self) -> Value {
        self.done(&json!({"do": "status"}))["mode"].clone()
    }

    /// Waits until the board is in this mode.
    fn until(&mut self, mode: &str) {
        let begun = Instant::now();
        while self.mode() != mode {
            assert!(begun.elapsed() < WAIT, "{}", self.mode());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn hold(&mut self) {
        self.done(&json!({"do": "arm"}));
        self.done(&json!({"do": "regulate", "angle_rad": [0.0, 0.0]}));
    }
}

fn server() -> Program {
    Program::serve(&["board", "--json", "tcp://127.0.0.1:0", "--quiet"])
}

fn observer(server: &Program) -> Client {
    let mut client = Client::of(server);
    client.done(&json!({"do": "observe"}));
    client
}

#[test]
fn a_session_from_arming_to_parking() {
    let server = server();
    let mut client = Client::of(&server);
    assert_eq!(client.mode(), "idle");
    let parameters = json!({"limits.torque_nm": [1.0, 1.0], "park.kind": "pose"});
    client.done(&json!({"do": "set", "parameters": parameters}));
    let answer = client.done(&json!({"do": "get"}));
    assert_eq!(answer["parameters"]["park.kind"], "pose");
    client.hold();
    let answer =
        client.done(&json!({"do": "move", "angle_rad": [0.2, -0.1], "duration_s": 0.5, "id": "m"}));
    assert_eq!(answer["id"], "m");
    client.done(&json!({"do": "take"}));
    let answer =
        client.done(&json!({"do": "take", "ticks": 50, "columns": ["tick", "reference_rad"]}));
    let columns = answer["columns"].as_object().unwrap();
    assert_eq!(
        columns.keys().collect::<Vec<_>>(),
        ["reference_rad_1", "reference_rad_2", "tick"]
    );
    let ticks = columns["tick"].as_array().unwrap();
    assert_eq!(ticks.len(), 50);
    assert_eq!(
        ticks[49].as_u64(),
        ticks[0].as_u64().map(|first| first + 49)
    );
    let reached = columns["reference_rad_1"][49].as_f64().unwrap();
    assert!((reached - 0.2).abs() < 1e-4, "{reached}");

    // A stream from where the arm is, by the times of its points.
    let begun = Instant::now();
    for k in 0..100 {
        let t_s = 0.01 * f64::from(k);
        std::thread::sleep(Duration::from_secs_f64(t_s).saturating_sub(begun.elapsed()));
        let angle_rad = [0.2 * (2.0 * t_s).cos(), -0.1];
        client.done(&json!({"do": "stream", "t_s": t_s, "angle_rad": angle_rad}));
    }
    client.done(&json!({"do": "torque", "torque_nm": [0.0, 0.0]}));
    client.done(&json!({"do": "regulate", "angle_rad": [0.0, 0.0]}));
    let experiment = json!({"roles": ["hold", "hold"], "duration_s": 0.3,
        "angle_rad": [[-0.5, 0.5], [-0.5, 0.5]], "speed_rad_s": [2.0, 2.0]});
    let answer = client.done(&json!({"do": "experiment", "experiment": experiment}));
    assert_eq!(answer["whole"], true);
    client.done(&json!({"do": "float"}));
    client.done(&json!({"do": "park"}));
    assert_eq!(client.mode(), "idle");
}

/// The link of a device, served by another process as a pseudo-terminal.
#[test]
fn a_board_at_a_device_is_served_too() {
    let board = Served::on("pty:");
    let link = board.link.to_string();
    let server = Program::serve(&["board", "--json", "tcp://127.0.0.1:0", "--link", &link]);
    let mut client = Client::of(&server);
    client.hold();
    client.until("regulate");
    let mut watching = observer(&server);
    drop(client);
    watching.until("idle");
}

#[test]
fn wrong_requests_are_answered_and_change_nothing() {
    let server = server();
    let mut client = Client::of(&server);
    client.fails(&json!([1]), "request", "no JSON object");
    client.fails(&json!({"do": "jump"}), "request", "unknown variant `jump`");
    client.fails(
        &json!({"do": "regulate", "angle_rad": [1]}),
        "request",
        "length 1",
    );
    client.fails(
        &json!({"do": "regulate", "angle_rad": [0, 0]}),
        "refused",
        "regulate",
    );
    client.fails(
        &json!({"do": "set", "parameters": {"arm.m2": 1}}),
        "request",
        "is it `arm.m2_kg`",
    );
    client.fails(
        &json!({"do": "set", "parameters": {"arm.m2_kg": "a"}}),
        "request",
        "arm.m2_kg",
    );
    client.fails(
        &json!({"do": "take", "ticks": 1_000_000}),
        "request",
        "at most 10000 ticks",
    );
    client.fails(
        &json!({"do": "take", "columns": ["angel_rad"]}),
        "request",
        "no column `angel_rad`",
    );
    // 4294.97 s are 2^32 µs and a few.
    for (joint, duration_s) in [(3, 0.1), (0, 0.1), (1, 4_295.0)] {
        let push =
            json!({"do": "push", "joint": joint, "torque_nm": 0.1, "duration_s": duration_s});
        client.fails(&push, "request", "at most 6 N m and 60 s");
    }
    for text in [
        "{\"do\":\"arm\"\n",
        "\u{0}\u{1}\n",
        "{\"do\":\"move\",\"angle_rad\":[1e99,0]}\n",
    ] {
        client.send(text);
        assert_eq!(client.receive()["ok"], false, "{text}");
    }
    client.send("\n\r\n");
    assert_eq!(client.mode(), "idle");
    // A line without an end is no reason to keep more of it.
    client.send(&"x".repeat(70_000));
    assert!(
        client.receive()["text"]
            .as_str()
            .unwrap()
            .contains("at most 65536 bytes")
    );
    assert_eq!(observer(&server).mode(), "idle");
}

#[test]
fn one_commands_others_watch_and_each_may_stop() {
    let server = server();
    let mut commander = Client::of(&server);
    commander.hold();
    let mut second = Client::of(&server);
    second.fails(&json!({"do": "disarm"}), "observer", "commands the board");
    second.until("regulate");
    // A stop is carried out while a motion is waited for.
    let far = json!({"do": "move", "angle_rad": [0.5, 0.0], "duration_s": 5.0});
    commander.send(&format!("{far}\n"));
    second.until("track");
    let begun = Instant::now();
    second.done(&json!({"do": "stop"}));
    assert_eq!(commander.receive()["error"], "fault");
    assert!(begun.elapsed() < Duration::from_secs(2));
    commander.done(&json!({"do": "clear"}));
    commander.hold();
    commander.send(&format!("{far}\n{}\n", json!({"id": 1, "do": "stop"})));
    let answers = [commander.receive(), commander.receive()];
    assert!(
        answers.iter().any(|it| it["id"] == 1 && it["ok"] == true),
        "{answers:?}"
    );
}

#[test]
fn a_program_that_leaves_in_any_way_leaves_no_arm_driven() {
    let server = server();
    let mut watching = observer(&server);
    // In mid line, and in mid motion.
    for rest in [
        "",
        "{\"do\":\"mo",
        "{\"do\":\"move\",\"angle_rad\":[0.4,0.0],\"duration_s\":9}\n",
    ] {
        let mut client = Client::of(&server);
        client.hold();
        watching.until("regulate");
        client.send(rest);
        client.lines.get_mut().shutdown(Shutdown::Both).unwrap();
        drop(client);
        watching.until("idle");
    }
}

#[test]
fn a_program_that_does_not_read_is_disconnected_and_the_arm_let_go_of() {
    let server = server();
    let mut watching = observer(&server);
    let mut client = Client::of(&server);
    client.hold();
    let request = format!("{}\n", json!({"do": "take", "ticks": 1})).repeat(1_000);
    let begun = Instant::now();
    // A million lines of answers that are not read.
    let stream = client.lines.get_mut();
    stream.set_write_timeout(Some(WAIT)).unwrap();
    let lines = (0..1_000).take_while(|_| stream.write_all(request.as_bytes()).is_ok());
    assert!(lines.count() < 1_000 && begun.elapsed() < WAIT);
    watching.until("idle");
}
