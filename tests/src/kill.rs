//! A recorder that is killed at any moment: the file has all but the last second.
//!
//! The one that is killed is this test program itself, started again to run
//! the test that calls [`record_until_killed`].

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use armbridge_client::event::Direction;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Mode, Record, Sample, Settings, TickInput, TickOutput, ToHost};
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Recording;
use armbridge_log::run_info::RunFacts;
use serde_json::Value;

use crate::paths;

/// Path of the log, for the process that is to be killed.
const LOG: &str = "ARMBRIDGE_TEST_LOG";

fn now_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    since.as_nanos() as u64
}

/// A tick of an arm at rest.
fn tick(tick: u32) -> Record {
    Record {
        tick,
        mode: Mode::Idle,
        input: TickInput {
            start_us: u64::from(tick) * 1_000,
            samples: [Sample::Counts(512); 2],
            ..TickInput::AT_REST
        },
        output: TickOutput {
            reference_rad: [0.1; 2],
            reference_speed_rad_s: [0.1; 2],
            angle_rad: [0.1; 2],
            speed_rad_s: [0.1; 2],
            torque_nm: [0.1; 2],
            disturbance_nm: [0.1; 2],
            ..TickOutput::NONE
        },
        ..Record::NONE
    }
}

/// Records until it is killed, if it was started for that: the body of a test that
/// [`kill`] names.
pub fn record_until_killed() {
    let Some(path) = std::env::var_os(LOG).map(PathBuf::from) else {
        return;
    };
    let facts = RunFacts::from_settings("test", "simulated: nothing", &Settings::default());
    let recorder = Recorder::create(&path, &facts).unwrap();
    let (mut tap, mut board) = (recorder.tap(), Encoder::default());
    let (start, mut count) = (Instant::now(), 0);
    // It ends after this time if it is not killed.
    while start.elapsed() < Duration::from_secs(30) {
        let due = start.elapsed().as_millis() as u32;
        while count < due {
            let frame = board.encode(&ToHost::Record(tick(count))).1;
            tap.bytes(Direction::ToHost, now_ns(), frame);
            count += 1;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn start(path: &Path, victim: &str) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", victim])
        .env(LOG, path)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Kills so many recorders, four at a time, which one disk can keep up with; what they
/// left in the folder, and when each was killed. `victim` is the path of the test to start.
pub fn kill(count: u64, folder: &Path, victim: &str) -> Vec<(PathBuf, u64)> {
    const AT_ONCE: u64 = 4;
    let (mut noise, mut killed) = (now_ns(), Vec::new());
    for batch in 0..count.div_ceil(AT_ONCE) {
        let begin = |i| {
            let path = folder.join(format!("{batch}-{i}.mcap"));
            (start(&path, victim), path)
        };
        let recorders: Vec<(Child, PathBuf)> = (0..AT_ONCE).map(begin).collect();
        for (mut child, path) in recorders {
            noise = noise
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            // 2.2 s for all of them, so that most have something, and none the same.
            std::thread::sleep(Duration::from_millis(400 + (noise >> 32) % 300));
            let at_ns = now_ns();
            child.kill().unwrap();
            child.wait().unwrap();
            killed.push((path, at_ns));
        }
    }
    killed
}

/// Part of a log that survived the kill.
#[derive(Default)]
pub struct RecoveredLog {
    /// Records.
    pub ticks: usize,
    /// Time of the last event on the host's clock.
    pub last_ns: u64,
    /// From the last event to the kill.
    pub missing_ms: u64,
}

/// Reads a log, and checks that at most its last second is missing.
pub fn read_recovered(path: &Path, killed_ns: u64) -> RecoveredLog {
    let Ok(recording) = Recording::load(path) else {
        // Killed before it had anything to lose.
        let len = path.metadata().map_or(0, |file| file.len());
        assert!(len < 60_000, "{len} bytes of {}", path.display());
        return RecoveredLog::default();
    };
    assert_eq!(recording.damage.len(), 1, "{:?}", recording.damage);
    let records = recording.records();
    let ticks = records.iter().map(|record| record.tick);
    assert!(ticks.eq(0..records.len() as u32), "{}", path.display());
    let Some(last) = recording.events.last() else {
        return RecoveredLog::default();
    };
    let missing_ms = killed_ns.saturating_sub(last.host_ns) / 1_000_000;
    assert!(missing_ms <= 1_000, "{missing_ms} ms of {}", path.display());
    RecoveredLog {
        ticks: records.len(),
        last_ns: last.host_ns,
        missing_ms,
    }
}

/// Output of `tests/python/log.py` for these logs, line by line.
pub fn python(mode: &str, logs: &[&Path]) -> Vec<Value> {
    let output = paths::script("log.py")
        .arg(mode)
        .args(logs)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let lines = String::from_utf8(output.stdout).unwrap();
    lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// The Python package `mcap` reads as much of each log as the host program; how many
/// milliseconds each misses, in order.
pub fn read_alike(killed: &[(PathBuf, u64)]) -> Vec<u64> {
    let paths: Vec<&Path> = killed.iter().map(|(path, _)| path.as_path()).collect();
    let theirs = python("killed", &paths);
    assert_eq!(theirs.len(), killed.len());
    let mut missing_ms = Vec::new();
    for ((path, at_ns), theirs) in killed.iter().zip(theirs) {
        let recovered = read_recovered(path, *at_ns);
        assert_eq!(theirs["ticks"], recovered.ticks, "{theirs}");
        assert_eq!(theirs["last_ns"], recovered.last_ns, "{theirs}");
        missing_ms.push(recovered.missing_ms);
    }
    missing_ms.sort_unstable();
    missing_ms
}
