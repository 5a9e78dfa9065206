//! Programs that were written for the vendor's USB adapter, as they are: its SDK
//! and pypot, rustypot and dynamixel2, on a pseudo-terminal of `armbridge`.
//!
//! Their scripts are in `tests/python/`, and those in Rust in `tests/masters/`. They have
//! time limits of their own, of the wall clock, so they ask again where a busy machine was late.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Output, Stdio};

use armbridge_tests::paths;

/// The servos by themselves, at the rate that the terminal is set to.
const SERVOS: &[&str] = &["serve", "servos", "--listen", "pty:", "--firmware", "stock"];

/// The same of the X series.
const X_SERVOS: &[&str] = &["serve", "servos", "--listen", "pty:", "--firmware", "x"];

/// Masters in `tests/masters/`.
const MASTERS: [&str; 2] = ["rustypot", "dynamixel2"];

/// The same behind the transparent port of the emulated board, with its arm
/// disarmed.
const BOARD: &[&str] = &[
    "serve",
    "board",
    "--link",
    "emulate:",
    "--transparent",
    "pty:",
    "--firmware",
    "stock",
];

/// `armbridge`, ended with the test.
struct Served {
    child: Child,
    /// The terminal that it serves.
    terminal: String,
}

impl Served {
    /// Runs it. Its stdout names the terminal that it serves.
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let stdout = child.stdout.take().unwrap();
        let mut lines = BufReader::new(stdout).lines().map_while(Result::ok);
        let terminal = lines.find(|line| line.starts_with("/dev/"));
        // Owned from here on, so that it ends with the test.
        let served = Self {
            child,
            terminal: terminal.unwrap_or_default(),
        };
        assert!(
            !served.terminal.is_empty(),
            "{arguments:?} names no terminal"
        );
        // Its other lines are of no interest, but must go somewhere.
        std::thread::spawn(move || lines.for_each(drop));
        served
    }

    /// Runs one of the scripts in `tests/python/` on it.
    fn run(&self, script: &str, options: &[&str]) -> Output {
        paths::script(script)
            .arg(&self.terminal)
            .args(options)
            .output()
            .unwrap()
    }

    fn passes(&self, script: &str, options: &[&str]) {
        let output = self.run(script, options);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{script} {options:?}: {stderr}");
        print!("{}", String::from_utf8_lossy(&output.stdout));
    }

    /// Runs one of the masters on it.
    fn run_master(&self, master: &str) -> Output {
        let mut masters = paths::masters();
        masters.args([master, &self.terminal]).output().unwrap()
    }

    fn is_driven_by(&self, master: &str) {
        let output = self.run_master(master);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{master}: {stderr}");
        print!("{}", String::from_utf8_lossy(&output.stdout));
    }

    fn fails(&self, script: &str, options: &[&str], why: &str) {
        let output = self.run(script, options);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.contains(why), "{script} {options:?}: {stderr}");
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_vectors_of_protocol_2_are_those_of_the_sdk() {
    let output = paths::script("protocol2_vectors.py").output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let kept = include_str!("../../../../shared/servo/tests/protocol2/vectors.txt");
    assert_eq!(String::from_utf8_lossy(&output.stdout), kept);
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_sdk_and_pypot_work_with_stock_servos() {
    let servos = Served::start(SERVOS);
    servos.passes("sdk.py", &["--fresh", "--rate-counts"]);
    servos.passes("pypot_io.py", &[]);
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_sdk_works_with_x_servos() {
    Served::start(X_SERVOS).passes("sdk2.py", &[]);
}

#[test]
#[ignore = "needs QEMU, the emulator's image and the Python packages: run `cargo verify`"]
fn the_sdk_works_with_x_servos_through_the_emulated_board() {
    Served::start(&x_board(&[])).passes("sdk2.py", &[]);
}

/// The board with servos of the X series.
fn x_board(options: &[&'static str]) -> Vec<&'static str> {
    let (last, before) = BOARD.split_last().unwrap();
    assert_eq!(*last, "stock");
    [before, &["x"], options].concat()
}

#[test]
#[ignore = "needs tests/masters: run `cargo verify`"]
fn the_vectors_of_the_masters_are_those_that_they_make() {
    let output = paths::masters().arg("vectors").output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let kept = include_str!("../../../../shared/servo/tests/protocol2/masters.txt");
    assert_eq!(String::from_utf8_lossy(&output.stdout), kept);
}

#[test]
#[ignore = "needs tests/masters: run `cargo verify`"]
fn rustypot_and_dynamixel2_work_with_x_servos() {
    let servos = Served::start(X_SERVOS);
    for master in MASTERS {
        servos.is_driven_by(master);
    }
}

#[test]
#[ignore = "needs QEMU, the emulator's image and tests/masters: run `cargo verify`"]
fn rustypot_and_dynamixel2_work_with_x_servos_through_the_emulated_board() {
    let board = Served::start(&x_board(&["--plant", "xl430"]));
    for master in MASTERS {
        board.is_driven_by(master);
    }
}

/// They see what is wrong.
#[test]
#[ignore = "needs tests/masters: run `cargo verify`"]
fn rustypot_and_dynamixel2_miss_a_servo_that_is_not_there() {
    let servos = Served::start(&[X_SERVOS, &["--ids", "1"]].concat());
    for master in MASTERS {
        let output = servos.run_master(master);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.contains("servos found"), "{master}: {stderr}");
    }
}

#[test]
#[ignore = "needs QEMU, the emulator's image and the Python packages: run `cargo verify`"]
fn the_sdk_and_pypot_work_through_the_emulated_board() {
    // A board each: what one leaves the arm at is not the other's affair.
    for (script, options) in [
        ("sdk.py", &["--fresh", "--rate-counts"][..]),
        ("pypot_io.py", &[]),
    ] {
        Served::start(BOARD).passes(script, options);
    }
}

/// The scripts see what is wrong.
#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_sdk_and_pypot_miss_servos_that_are_not_there() {
    let servos = Served::start(SERVOS);
    servos.fails(
        "sdk.py",
        &["--ids", "1", "3"],
        "ping 3: [TxRxResult] There is no status packet!",
    );
    servos.fails(
        "sdk.py",
        &["--ids", "1"],
        "there is no servo 2, and it answers",
    );
    servos.fails(
        "pypot_io.py",
        &["--ids", "2", "3"],
        "ids: [1, 2], should be [2, 3]",
    );
}
