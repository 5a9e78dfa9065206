//! Whoever records is killed, at any moment: the file has all but the last second.
//!
//! The one that is killed is this test program itself, started again to run
//! [`records_until_it_is_killed`].

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use armbridge_client::event::Direction;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Recording;
use armbridge_log::run_info::RunFacts;
use armbridge_shared::link::frame::Encoder;
use armbridge_shared::link::message::{Guards, Mode, Record, Sample, Settings, Timing, ToHost};

use crate::{folder, python};

/// Tells the one that is to be killed where to record.
const LOG: &str = "ARMBRIDGE_TEST_LOG";

fn now_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    since.as_nanos() as u64
}

/// A tick of an arm at rest.
fn tick(tick: u32) -> Record {
    Record {
        tick,
        start_us: u64::from(tick) * 1_000,
        mode: Mode::Idle,
        guards: Guards::NONE,
        samples: [Sample::Counts(512); 2],
        alarms: [0; 2],
        pwm_in_force: [1_000; 2],
        pwm_next: [1_000; 2],
        reference_rad: [0.1; 2],
        reference_speed_rad_s: [0.1; 2],
        angle_rad: [0.1; 2],
        speed_rad_s: [0.1; 2],
        torque_nm: [0.1; 2],
        disturbance_nm: [0.1; 2],
        timing: Timing::default(),
        dropped: 0,
    }
}

/// Not a test unless one of those below starts it.
#[test]
fn records_until_it_is_killed() {
    let Some(path) = std::env::var_os(LOG).map(PathBuf::from) else {
        return;
    };
    let facts = RunFacts::of("test", "simulated: nothing", &Settings::default());
    let recorder = Recorder::create(&path, &facts).unwrap();
    let (mut tap, mut board) = (recorder.tap(), Encoder::default());
    let (start, mut count) = (Instant::now(), 0);
    // Nobody waits for longer, even if it is not killed.
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

fn start(path: &Path) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "kill::records_until_it_is_killed"])
        .env(LOG, path)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Kills so many recorders, four at a time, which one disk can keep up with; what they
/// left, and when each was killed.
fn kill(count: u64, name: &str) -> Vec<(PathBuf, u64)> {
    const AT_ONCE: u64 = 4;
    let folder = folder(name);
    let (mut noise, mut killed) = (now_ns(), Vec::new());
    for batch in 0..count.div_ceil(AT_ONCE) {
        let begin = |i| {
            let path = folder.join(format!("{batch}-{i}.mcap"));
            (start(&path), path)
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

/// What we read of a log.
#[derive(Default)]
struct Looked {
    ticks: usize,
    last_ns: u64,
    missing_ms: u64,
}

/// All ticks are there but for the last second.
fn look(path: &Path, killed_ns: u64) -> Looked {
    let Ok(recording) = Recording::load(path) else {
        // Killed before it had anything to lose.
        let len = path.metadata().map_or(0, |file| file.len());
        assert!(len < 60_000, "{len} bytes of {}", path.display());
        return Looked::default();
    };
    assert_eq!(recording.damage.len(), 1, "{:?}", recording.damage);
    let records = recording.records();
    let ticks = records.iter().map(|record| record.tick);
    assert!(ticks.eq(0..records.len() as u32), "{}", path.display());
    let Some(last) = recording.events.last() else {
        return Looked::default();
    };
    let missing_ms = killed_ns.saturating_sub(last.host_ns) / 1_000_000;
    assert!(missing_ms <= 1_000, "{missing_ms} ms of {}", path.display());
    Looked {
        ticks: records.len(),
        last_ns: last.host_ns,
        missing_ms,
    }
}

#[test]
fn a_kill_takes_the_last_second_at_most() {
    let killed = kill(20, "killed");
    let looked = killed.iter().map(|(path, at_ns)| look(path, *at_ns).ticks);
    assert!(looked.filter(|ticks| *ticks > 500).count() > 10);
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_mcap_package_reads_as_much_of_a_hundred_that_were_killed() {
    let killed = kill(100, "killed_100");
    let paths: Vec<&Path> = killed.iter().map(|(path, _)| path.as_path()).collect();
    let theirs = python("killed", &paths);
    assert_eq!(theirs.len(), 100);
    let mut missing_ms = Vec::new();
    for ((path, at_ns), theirs) in killed.iter().zip(theirs) {
        let looked = look(path, *at_ns);
        assert_eq!(theirs["ticks"], looked.ticks, "{theirs}");
        assert_eq!(theirs["last_ns"], looked.last_ns, "{theirs}");
        missing_ms.push(looked.missing_ms);
    }
    missing_ms.sort_unstable();
    let (median, worst) = (missing_ms[50], missing_ms[99]);
    println!("100 killed: {median} ms are missing in the median, {worst} ms at most");
}
