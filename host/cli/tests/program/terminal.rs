//! `armbridge watch` on a terminal of its own: however it ends, the terminal is as it
//! was before, and the board is disarmed; also when the terminal goes away.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{self, Child, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use armbridge_client::event::EventKind;
use armbridge_control::arm::State;
use armbridge_link::message::{Command, Mode, ToBoard, ToHost};
use armbridge_log::recording::Recording;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::served_board::{Served, until};
use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcgetattr, tcsetwinsize};

use super::links::program as links;

/// Time-out of any step on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

const ENTERS: &str = "\u{1b}[?1049h";
const LEAVES: &str = "\u{1b}[?1049l";

/// A dashboard, and what it has drawn so far.
struct Dashboard {
    child: Child,
    keyboard: File,
    terminal: OwnedFd,
    drawn: Arc<Mutex<Vec<u8>>>,
    /// Its screen is closed: nothing is read from it, and its end is no longer held.
    is_closed: Arc<AtomicBool>,
    reader: Option<std::thread::JoinHandle<()>>,
}

/// Reads a screen until it is closed.
fn read(mut screen: File, seen: &Mutex<Vec<u8>>, is_closed: &AtomicBool) {
    let mut bytes = [0; 4096];
    let wait = Timespec {
        tv_sec: 0,
        tv_nsec: 20_000_000,
    };
    while !is_closed.load(Ordering::Relaxed) {
        let mut ready = [PollFd::new(&screen, PollFlags::IN)];
        if rustix::event::poll(&mut ready, Some(&wait)).unwrap() == 0 {
            continue;
        }
        match screen.read(&mut bytes) {
            Ok(count @ 1..) => seen.lock().unwrap().extend_from_slice(&bytes[..count]),
            Ok(0) | Err(_) => return,
        }
    }
}

impl Dashboard {
    fn start(options: &[&str]) -> Self {
        Self::on("sim:", options)
    }

    fn on(link: &str, options: &[&str]) -> Self {
        Self::of(&[&["watch", "--link", link], options].concat())
    }

    /// Any command with a terminal of its own.
    fn of(args: &[&str]) -> Self {
        // A program that inherited the controlling end would keep its own terminal open.
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let controller = openpt(flags).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let name = ptsname(&controller, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
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
            .args(args)
            .env("TERM", "xterm")
            .stdin(end())
            .stdout(end())
            .stderr(end())
            .spawn()
            .unwrap();
        let keyboard = File::from(controller);
        let screen = keyboard.try_clone().unwrap();
        let (drawn, is_closed) = (Arc::<Mutex<Vec<u8>>>::default(), Arc::default());
        let (seen, closed) = (Arc::clone(&drawn), Arc::clone(&is_closed));
        let reader = std::thread::spawn(move || read(screen, &seen, &closed));
        Self {
            child,
            keyboard,
            terminal,
            drawn,
            is_closed,
            reader: Some(reader),
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

    /// Sends a signal.
    fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let sent = process::Command::new("kill").args([name, &id]).status();
        assert!(sent.unwrap().success());
    }

    /// Waits for its end, and sees that the terminal is as it was.
    fn ended(mut self) -> ExitStatus {
        let status = end_of(&mut self.child);
        self.until(LEAVES);
        let drawn = self.drawn();
        let entered = drawn.find(ENTERS).expect("the screen is entered");
        assert!(Some(entered) < drawn.rfind(LEAVES), "{drawn}");
        // Lines are edited and echoed again.
        let modes = tcgetattr(&self.terminal).unwrap().local_modes;
        let cooked = rustix::termios::LocalModes::ICANON | rustix::termios::LocalModes::ECHO;
        assert!(modes.contains(cooked), "{modes:?}");
        status
    }
}

impl Dashboard {
    /// Closes the terminal, as `sshd` does when the connection drops, and waits for the end.
    fn hang_up(mut self) -> ExitStatus {
        self.is_closed.store(true, Ordering::Relaxed);
        self.reader.take().unwrap().join().unwrap();
        drop(self.keyboard);
        end_of(&mut self.child)
    }
}

fn end_of(child: &mut Child) -> ExitStatus {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Whether in this log the board acknowledges that it disarms, and the host's goodbye
/// follows.
fn is_left_disarmed(path: &Path) -> bool {
    let recording = Recording::load(path).unwrap();
    let events: Vec<&EventKind> = recording.events.iter().map(|event| &event.kind).collect();
    let idle = events.iter().rev().find_map(|event| match event {
        EventKind::Sent(sequence, ToBoard::Command(Command::Park)) => Some(*sequence),
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
    let (mut dashboard, log) = running(folder.path());
    dashboard.press("q");
    assert_eq!(dashboard.ended().code(), Some(0));
    assert!(is_left_disarmed(&log));
}

#[test]
fn a_request_to_terminate_restores_the_terminal_too() {
    let dashboard = Dashboard::start(&[]);
    dashboard.until("IDLE");
    dashboard.signal("-TERM");
    assert_eq!(dashboard.ended().code(), Some(143));
}

/// A board that is served at this address, also after another one.
fn served(link: &str) -> Served {
    Served::with_arm(
        link,
        &PlantConfig {
            initial: State::at_rest([0.3, -0.25].into()),
            ..PlantConfig::default()
        },
    )
}

#[test]
fn an_observer_stays_one_when_it_is_first_and_after_a_restart() {
    let board = served(links::TCP);
    let link = board.link.clone();
    let name = link.to_string();
    let mut dashboard = Dashboard::on(&name, &["--observe"]);
    // Only single words: blanks of a line are not drawn.
    dashboard.until("OBSERVING");
    dashboard.until("IDLE");
    let arm = ["arm", "--for", "1"];
    links::assert_ends(&links::run(&link, &arm), 0, "; disarmed");
    dashboard.until("(process");
    // Its keys do not command.
    dashboard.press("a");
    dashboard.until("observes,");
    drop(board);
    dashboard.until("LOST");
    let board = served(&name);
    until("it is back", || {
        let drawn = dashboard.drawn();
        let since = drawn.rsplit("LOST").next();
        since.is_some_and(|since| since.contains("IDLE"))
    });
    links::assert_ends(&links::run(&link, &arm), 0, "; disarmed");
    assert_eq!(board.seen().mode, Mode::Idle);
    dashboard.press(" ");
    board.until("stopped", |seen| matches!(seen.mode, Mode::Fault(_)));
    dashboard.press("q");
    assert_eq!(dashboard.ended().code(), Some(0));
}

#[test]
fn keys_touch_a_served_arm() {
    let board = served(links::TCP);
    let mut dashboard = Dashboard::on(&board.link.to_string(), &[]);
    dashboard.until("COMMANDING");
    dashboard.until("IDLE");
    let released = links::run(&board.link, &["hand", "--release"]);
    links::assert_ends(&released, 0, "lets go");
    board.until("it has fallen", |seen| seen.angle_rad[0] > 0.8);
    dashboard.press("l");
    board.until("it is lifted", |seen| {
        (seen.angle_rad[0] - 0.3).abs() < 1e-9 && (seen.angle_rad[1] + 0.25).abs() < 1e-9
    });
    dashboard.press("r");
    dashboard.until("hold here");
    dashboard.press("h");
    board.until("it is held", |seen| seen.mode.drive().is_some());
    std::thread::sleep(Duration::from_millis(500));
    let before = board.seen().angle_rad[0];
    dashboard.press("1");
    board.until("it is pushed", |seen| seen.angle_rad[0] > before + 0.01);
    dashboard.press("q");
    assert_eq!(dashboard.ended().code(), Some(0));
    board.until_off();
}

#[test]
fn what_cannot_be_observed_is_refused() {
    let refused = |link: &str, words: &str| {
        let mut dashboard = Dashboard::on(link, &["--observe"]);
        dashboard.until(words);
        assert_eq!(dashboard.child.wait().unwrap().code(), Some(2));
    };
    refused("sim:", "in this program alone");
    let silent = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let silent = format!("tcp://{}", silent.local_addr().unwrap());
    refused(&silent, "cannot be observed");
}

/// A dashboard whose arm stands, and its log.
fn running(folder: &Path) -> (Dashboard, std::path::PathBuf) {
    let log = folder.join("run.mcap");
    let mut dashboard = Dashboard::start(&["--record", log.to_str().unwrap()]);
    dashboard.until("IDLE");
    dashboard.press("r");
    dashboard.until("hold here");
    dashboard.press("h");
    dashboard.until("RUNNING");
    (dashboard, log)
}

#[test]
fn a_terminal_that_goes_away_disarms_closes_the_log_and_ends() {
    let folder = tempfile::tempdir().unwrap();
    let (dashboard, log) = running(folder.path());
    assert_eq!(dashboard.hang_up().code(), Some(129));
    assert!(is_left_disarmed(&log));
    assert_eq!(Recording::load(&log).unwrap().damage, [""; 0]);
}

#[test]
fn hang_ups_of_kernel_and_shell_disarm_before_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let (dashboard, log) = running(folder.path());
    dashboard.signal("-HUP");
    dashboard.signal("-HUP");
    assert_eq!(dashboard.hang_up().code(), Some(129));
    assert!(is_left_disarmed(&log));
    assert_eq!(Recording::load(&log).unwrap().damage, [""; 0]);
}

#[test]
fn a_calibration_ends_with_its_terminal_and_changes_nothing() {
    let board = served(links::TCP);
    let link = board.link.to_string();
    let calibration = Dashboard::of(&["calibrate", "--link", &link]);
    calibration.until("press Enter");
    let code = calibration.hang_up().code();
    assert!(matches!(code, Some(2 | 129)), "{code:?}");
    assert_eq!(board.seen().mode, Mode::Idle);
    // Another program commands the board at once.
    let arm = ["arm", "--for", "1"];
    links::assert_ends(&links::run(&board.link, &arm), 0, "; disarmed");
}
