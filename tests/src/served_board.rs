//! A board and its arm, served on a link in a thread of its own, in wall-clock time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use armbridge_board::bridge::Channels;
use armbridge_client::endpoint::Exposure;
use armbridge_client::transport::LinkUri;
use armbridge_link::message::{BoardReport, End, LastEnd, Mode};
use armbridge_sim::Bench;
use armbridge_sim::board::{VirtualBoard, blank_flash};
use armbridge_sim::cosim::Cosim;
use armbridge_sim::link_server::LinkServer;
use armbridge_sim::plant::{Plant, PlantConfig};

/// The motors off.
pub const OFF: [u16; 2] = [1_000; 2];
/// A busy machine may take this long for anything.
const LONG: Duration = Duration::from_secs(30);

/// State of a served board, as seen on its link.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The mode.
    pub mode: Mode,
    /// In force in the servos.
    pub pwm: [u16; 2],
    /// True angles of the arm in rad.
    pub angle_rad: [f64; 2],
    /// Simulated time, in µs.
    pub now_us: u64,
}

/// A served board.
pub struct Served {
    /// Where.
    pub link: LinkUri,
    seen: Arc<Mutex<Seen>>,
    is_over: Arc<AtomicBool>,
    is_reset_due: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    /// On a link that can be offered, such as `tcp://127.0.0.1:0` or `pty:`.
    pub fn on(name: &str) -> Self {
        Self::with_arm(name, &PlantConfig::default())
    }

    /// The same with an arm of its own.
    pub fn with_arm(name: &str, arm: &PlantConfig) -> Self {
        let (host, link) = LinkServer::offer(&name.parse().unwrap(), Exposure::Loopback).unwrap();
        let seen = Arc::new(Mutex::new(Seen {
            mode: Mode::Boot,
            pwm: OFF,
            angle_rad: [0.0; 2],
            now_us: 0,
        }));
        let (is_over, is_reset_due) = (Arc::default(), Arc::default());
        let thread = {
            let (seen, is_over) = (Arc::clone(&seen), Arc::clone(&is_over));
            let is_reset_due = Arc::clone(&is_reset_due);
            let arm = Plant::new(*arm, 1);
            std::thread::spawn(move || serve(host, arm, &seen, &is_over, &is_reset_due))
        };
        Self {
            link,
            seen,
            is_over,
            is_reset_due,
            thread: Some(thread),
        }
    }

    /// As it is.
    pub fn seen(&self) -> Seen {
        *self.seen.lock().unwrap()
    }

    /// Resets the board, as by its watchdog.
    pub fn reset(&self) {
        self.is_reset_due.store(true, Ordering::Relaxed);
    }

    /// Waits until it is so.
    pub fn until(&self, condition: &str, is_so: impl Fn(&Seen) -> bool) {
        until(condition, || is_so(&self.seen()));
    }

    /// Waits until the motors are off.
    pub fn until_off(&self) {
        self.until("motors are off", |seen| {
            seen.pwm == OFF && !seen.mode.is_armed()
        });
    }
}

/// Waits until it is so.
pub fn until(condition: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < LONG, "never: {condition}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn serve(
    mut host: LinkServer,
    arm: Plant,
    seen: &Mutex<Seen>,
    is_over: &AtomicBool,
    is_reset_due: &AtomicBool,
) {
    let (mut first, mut second) = (Channels::new(), Channels::new());
    let mut after = Some(second.split());
    let board = VirtualBoard::new(first.split()).unwrap();
    let bench = Bench::new(arm);
    let interactions = host.interactions();
    let mut run = Cosim::new(board, bench, host);
    if let Some(interactions) = interactions {
        run = run.with_interactions(interactions);
    }
    while !is_over.load(Ordering::Relaxed) {
        run.step().unwrap();
        if is_reset_due.swap(false, Ordering::Relaxed)
            && let Some(ends) = after.take()
        {
            let report = BoardReport {
                session: 2,
                last_end: LastEnd {
                    cause: End::Watchdog,
                    tick: 1_234,
                    ..LastEnd::default()
                },
                ..BoardReport::default()
            };
            run.board = VirtualBoard::after_reset(ends, blank_flash(), report).unwrap();
            run.board.shift_clock(-(run.now_us() as i64));
        }
        *seen.lock().unwrap() = Seen {
            mode: run.board.mode(),
            pwm: [run.bench.applied_pwm(0), run.bench.applied_pwm(1)],
            angle_rad: run.bench.plant().state().q.into(),
            now_us: run.now_us(),
        };
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking());
        }
    }
}
