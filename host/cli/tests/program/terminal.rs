//! `armbridge watch` on a terminal of its own: however it ends, the terminal is as it
//! was before, and the board is disarmed.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{self, Child, ExitStatus};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use armbridge_client::event::EventKind;
use armbridge_log::recording::Recording;
use armbridge_shared::link::message::{Command, ToBoard, ToHost};
use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcgetattr, tcsetwinsize};

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

const ENTERS: &str = "\u{1b}[?1049h";
const LEAVES: &str = "\u{1b}[?1049l";

/// A dashboard, and what it has drawn so far.
struct Dashboard {
    child: Child,
    keyboard: File,
    terminal: OwnedFd,
    drawn: Arc<Mutex<Vec<u8>>>,
}

impl Dashboard {
    fn start(options: &[&str]) -> Self {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let name = ptsname(&controller, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY;
        let terminal = rustix::fs::open(&*name, flags, rustix::fs::Mode::empty()).unwrap();
        let size = Winsize {
            ws_row: 24,
            ws_col: 80,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&terminal, size).unwrap();
        let end = || terminal.try_clone().unwrap();
        let child = process::Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .args(["watch", "--link", "sim:"])
            .args(options)
            .env("TERM", "xterm")
            .stdin(end())
            .stdout(end())
            .stderr(end())
            .spawn()
            .unwrap();
        let keyboard = File::from(controller);
        let mut screen = keyboard.try_clone().unwrap();
        let drawn = Arc::new(Mutex::new(Vec::new()));
        let seen = Arc::clone(&drawn);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = screen.read(&mut bytes) {
                seen.lock().unwrap().extend_from_slice(&bytes[..count]);
            }
        });
        Self {
            child,
            keyboard,
            terminal,
            drawn,
        }
    }

    /// Waits until this has been drawn since the beginning.
    fn until(&self, text: &str) {
        let begun = Instant::now();
        while !self.drawn().contains(text) {
            assert!(begun.elapsed() < PATIENCE, "no {text}: {}", self.drawn());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn drawn(&self) -> String {
        String::from_utf8_lossy(&self.drawn.lock().unwrap()).into_owned()
    }

    fn press(&mut self, keys: &str) {
        self.keyboard.write_all(keys.as_bytes()).unwrap();
    }

    /// Waits for its end, and sees that the terminal is as it was.
    fn ended(mut self) -> ExitStatus {
        let begun = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(begun.elapsed() < PATIENCE, "it does not end");
            std::thread::sleep(Duration::from_millis(20));
        };
        self.until(LEAVES);
        let drawn = self.drawn();
        assert!(drawn.find(ENTERS) < drawn.rfind(LEAVES), "{drawn}");
        // Lines are edited and echoed again.
        let modes = tcgetattr(&self.terminal).unwrap().local_modes;
        let cooked = rustix::termios::LocalModes::ICANON | rustix::termios::LocalModes::ECHO;
        assert!(modes.contains(cooked), "{modes:?}");
        status
    }
}

/// Whether in this log the board acknowledges that it disarms, and the host's goodbye
/// follows.
fn is_left_disarmed(path: &Path) -> bool {
    let recording = Recording::load(path).unwrap();
    let events: Vec<&EventKind> = recording.events.iter().map(|event| &event.kind).collect();
    let idle = events.iter().rev().find_map(|event| match event {
        EventKind::Sent(sequence, ToBoard::Command(Command::Idle)) => Some(*sequence),
        _ => None,
    });
    let taken = events.iter().position(|event| {
        matches!(event, EventKind::Received(_, ToHost::Ack { sequence, result: Ok(()), .. })
            if Some(*sequence) == idle)
    });
    let is_farewell = |kind: &&EventKind| matches!(kind, EventKind::Sent(_, ToBoard::Goodbye));
    let farewell = events.iter().position(is_farewell);
    taken.is_some() && taken < farewell
}

#[test]
fn a_running_arm_is_disarmed_by_q_and_the_terminal_is_restored() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("run.mcap");
    let mut dashboard = Dashboard::start(&["--record", log.to_str().unwrap()]);
    dashboard.until("IDLE");
    dashboard.press("r");
    dashboard.until("hold here");
    dashboard.press("h");
    dashboard.until("RUNNING");
    dashboard.press("q");
    assert_eq!(dashboard.ended().code(), Some(0));
    assert!(is_left_disarmed(&log));
}

#[test]
fn a_request_to_terminate_restores_the_terminal_too() {
    let dashboard = Dashboard::start(&[]);
    dashboard.until("IDLE");
    let id = dashboard.child.id().to_string();
    assert!(
        process::Command::new("kill")
            .arg(id)
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(dashboard.ended().code(), Some(0));
}
