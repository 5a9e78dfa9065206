//! `armbridge scan` and `armbridge servo` as a user meets them.

use std::process::{Command, Output, Stdio};

use armbridge_tests::served_servos::{MORPHEUS_ARM, await_temperature, serve};

fn run(port: &str, args: &[&str]) -> Output {
    run_patiently(port, "200", args)
}

fn run_patiently(port: &str, patience_ms: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    command.args(args);
    command.args(["--port", port, "--patience", patience_ms]);
    command.stdin(Stdio::null()).output().unwrap()
}

/// Exit code, standard output and standard error.
fn ended(output: &Output) -> (Option<i32>, &str, &str) {
    let text = |bytes| std::str::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

#[test]
fn who_is_there_and_what_they_hold() {
    let at = serve(&MORPHEUS_ARM, true);
    await_temperature(&at);
    let port = at.port();
    let output = run(&port, &["scan", "--ids", "1..2"]);
    let (code, out, err) = ended(&output);
    assert_eq!((code, err), (Some(0), ""));
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[3].starts_with("Morpheus servos answer"), "{out}");
    assert!(lines[2].starts_with("2   Morpheus") && lines[2].contains("300 counts"));

    let output = run(&port, &["scan", "--ids", "2", "--json"]);
    let (code, out, _) = ended(&output);
    let found: serde_json::Value = serde_json::from_str(out).unwrap();
    assert_eq!(code, Some(0));
    assert_eq!(found["servos"][0]["id"], 2);
    assert_eq!(found["servos"][0]["temperature_counts"], 300);
    assert_eq!(found["servos"][0]["voltage_v"], serde_json::Value::Null);

    let output = run(&port, &["scan", "--ids", "7"]);
    let (code, out, _) = ended(&output);
    assert!(
        code == Some(1) && out.contains("No servo has answered: only our own bytes"),
        "{out}"
    );

    let output = run(&port, &["servo", "2", "read"]);
    let (code, out, _) = ended(&output);
    assert_eq!(code, Some(0));
    // A line for the servo, one for the heads, one for each register.
    assert_eq!(out.lines().count(), 2 + 15, "{out}");
    assert!(
        out.contains("0x??") && out.contains("1000000 baud"),
        "{out}"
    );
    let output = run(&port, &["servo", "2", "read", "0x0e", "--json"]);
    let (_, out, _) = ended(&output);
    let read: serde_json::Value = serde_json::from_str(out).unwrap();
    assert_eq!(read["registers"][0]["name"], "temperature");
    assert_eq!(read["registers"][0]["value"], 300);
}

#[test]
fn exit_codes_tell_the_servos_fault_from_the_users() {
    let at = serve(&MORPHEUS_ARM, true);
    let port = at.port();
    for (args, expected, words) in [
        (["servo", "3", "read"].as_slice(), 1, "only our own bytes"),
        (&["servo", "1", "set-id", "2", "--yes"], 1, "is taken"),
        (&["servo", "1", "read", "torque"], 2, "it has magic, id"),
        (&["servo", "1", "write", "pwm", "1100"], 2, "--yes"),
        (&["servo", "1", "factory-reset"], 2, "--yes"),
        (&["servo", "1", "set-id", "4"], 2, "--yes"),
        (&["servo", "1", "write", "pwm", "2001"], 2, "from 0 to 2000"),
        (&["servo", "1", "set-baud", "57600", "--yes"], 2, "--blind"),
        (&["servo", "254", "read"], 2, "0..=253"),
        (&["scan", "--ids", "3..1"], 2, "expected ids"),
    ] {
        let output = run(&port, args);
        let (code, out, err) = ended(&output);
        assert_eq!((code, out), (Some(expected), ""), "{args:?}: {err}");
        assert!(err.contains(words), "{args:?}: {err}");
        assert_eq!(err.lines().count(), 1, "{err}");
    }
    // A stop needs no confirmation; a confirmed action is performed.
    for args in [
        ["servo", "1", "write", "pwm", "1100", "--yes"].as_slice(),
        &["servo", "1", "write", "pwm", "1000"],
    ] {
        let output = run(&port, args);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
    let output = Command::new(env!("CARGO_BIN_EXE_armbridge"))
        .args(["servo", "1", "read"])
        .output()
        .unwrap();
    let (code, _, err) = ended(&output);
    assert!(code == Some(2) && err.contains("--port"), "{err}");
}

/// The board's own port, with nothing to do but to pass what comes.
#[test]
fn through_the_boards_transparent_port() {
    use std::io::{BufRead, BufReader};

    for firmware in ["morpheus", "stock"] {
        let mut board = Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .args(["serve", "board", "--link", "sim:", "--firmware", firmware])
            .args(["--transparent", "tcp://127.0.0.1:0"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = BufReader::new(board.stderr.take().unwrap());
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        let port = line
            .split([' ', ','])
            .find(|word| word.starts_with("tcp://"));
        let outputs = [["servo", "1", "read"], ["servo", "2", "read"]]
            .map(|args| run(port.expect(&line), &args));
        board.kill().unwrap();
        board.wait().unwrap();
        for output in outputs {
            let (code, out, err) = ended(&output);
            assert_eq!(code, Some(0), "{firmware}: {err}");
            assert!(out.contains("1000000 baud"), "{out}");
        }
    }
}

/// On a terminal there is a question, and a no is taken for one.
#[test]
#[cfg(unix)]
fn on_a_terminal_one_is_asked() {
    use armbridge_client::pty::Pty;
    use std::io::Write;

    let at = serve(&MORPHEUS_ARM, true);
    let port = at.port();
    let terminal = Pty::open().unwrap();
    for (answer, expected) in [("n\n", 2), ("\n", 2), ("y\n", 0)] {
        let mut options = std::fs::OpenOptions::new();
        let input = options
            .read(true)
            .write(true)
            .open(terminal.name())
            .unwrap();
        terminal
            .controller()
            .unwrap()
            .write_all(answer.as_bytes())
            .unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .args([
                "servo",
                "1",
                "write",
                "pwm",
                "1001",
                "--port",
                &port,
                "--patience",
                "200",
            ])
            .stdin(input)
            .output()
            .unwrap();
        let (code, _, err) = ended(&output);
        assert_eq!(code, Some(expected), "{err}");
        assert!(
            err.contains("can move servo 1") && err.contains("[y/N]"),
            "{err}"
        );
        assert_eq!(err.contains("nothing was changed"), expected == 2, "{err}");
    }
}

/// A serial device that is a pseudo-terminal, rates and all.
#[test]
#[cfg(unix)]
fn over_a_serial_device() {
    use armbridge_client::pty::Pty;
    use armbridge_servo::Firmware as Kind;
    use armbridge_tests::served_servos::bench;

    let pty = Pty::open().unwrap();
    let ours = pty.controller().unwrap();
    let (from, to) = (pty.controller().unwrap(), pty.controller().unwrap());
    let servos = [(Kind::Stock, 1, 57_600), (Kind::Stock, 2, 1_000_000)];
    std::thread::spawn(move || bench(&servos).serve(from, to, move || Pty::baud(&ours), true));
    // A lost answer cannot be made up for in a scan.
    let run = |args: &[&str]| run_patiently(pty.name(), "600", args);
    let scan = |expected: [(u8, u32); 2]| {
        let args = [
            "scan",
            "--ids",
            "1..2",
            "--bauds",
            "1000000,57600",
            "--json",
        ];
        let output = run(&args);
        let (code, out, err) = ended(&output);
        assert_eq!(code, Some(0), "{err}");
        let found: serde_json::Value = serde_json::from_str(out).unwrap();
        for (servo, (id, baud)) in expected.into_iter().enumerate() {
            let servo = &found["servos"][servo];
            assert_eq!(
                (&servo["id"], &servo["baud"]),
                (&id.into(), &baud.into()),
                "{out}"
            );
            assert_eq!(servo["model"], 12);
        }
    };
    scan([(1, 57_600), (2, 1_000_000)]);
    let args = ["servo", "2", "set-baud", "57600", "--yes"];
    let output = run(&args);
    let (code, out, err) = ended(&output);
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("57600 baud, read back"), "{out}");
    scan([(1, 57_600), (2, 57_600)]);
    let args = ["servo", "2", "read", "present_voltage", "--baud", "57600"];
    let output = run(&args);
    let (code, out, err) = ended(&output);
    assert_eq!(code, Some(0), "{err}");
    assert!(
        out.starts_with("present_voltage") && out.contains(" V"),
        "{out}"
    );
}
