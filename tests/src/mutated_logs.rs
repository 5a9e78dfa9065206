//! Logs as a stranger may send them: mutated ones, read in every way that the program has.
//!
//! Even seeds damage bytes anywhere: flipped bits, a cut end, zeros, the rest of another log,
//! chunks that are doubled or in another order. Odd seeds aim: at lengths of records, of
//! strings and of maps, declared sizes of chunks, the index's place, and numbers inside of
//! chunks, whose checksum is taken away so that they are read. Some more logs are made to fill
//! the memory ([`hostile`]).
//!
//! A child process reads them, which is this test program itself, started again for the test
//! that calls [`read_mutated`]. Its memory is limited by the system, so that a reservation
//! ends it whether or not it is ever written to.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use armbridge_analysis::identify::{KnownParameters, Prior, Tally, identify, traces};
use armbridge_analysis::plan_runner::Script;
use armbridge_analysis::plot::{self, Figure, Formats};
use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Command as BoardCommand, Settings, Setup, ToBoard};
use armbridge_log::export::{self, Format};
use armbridge_log::inspect::{Diff, Head, Info, Log, log};
use armbridge_log::output_file::{Existing, OutputFile};
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::{Reader, Recording};
use armbridge_log::replay::{Changes, Replayer};
use armbridge_log::run_info::RunFacts;
use armbridge_log::time_origin::Align;

use crate::tapped_bench::{Action, ScriptedHost, recorded, tapped_run};
use crate::{plant, sinusoid};

mod hostile;
mod mcap_bytes;

use mcap_bytes::mutated;

/// Memory that a reader may reserve, in KiB: 512 MB.
const MEMORY_KIB: u64 = 512_000_000 / 1024;

/// Longest time for one way of reading one log, of the processor: other processes do not count.
const TIME: Duration = Duration::from_secs(5);

/// Folder of the logs, and the first and last seed, for the child process.
const FOLDER: &str = "ARMBRIDGE_TEST_MUTATED";

/// Begin of a line of the child with the name of a log.
const LOG: &str = "log: ";

/// Largest figures over all logs.
#[derive(Clone, Debug)]
pub struct Largest {
    /// Resident memory of the child in bytes.
    pub memory_bytes: u64,
    /// Time of one way of reading one log.
    pub time: Duration,
    /// Which.
    pub longest: String,
}

/// Reads the mutated logs of these seeds in a child process; `reader` is the path of the test
/// that calls [`read_mutated`].
///
/// # Panics
/// If a reader panics, takes too long, or reserves too much memory.
pub fn read_all(seeds: Range<u64>, folder: &Path, reader: &str) -> Largest {
    for (name, events) in [("a", demo()), ("b", commands())] {
        record(&folder.join(name).with_extension("mcap"), &events);
    }
    let limited = format!("ulimit -d {MEMORY_KIB} && exec \"$0\" \"$@\"");
    let output = Command::new("sh")
        .args(["-c", &limited])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", reader, "--nocapture"])
        .env(
            FOLDER,
            format!("{} {} {}", folder.display(), seeds.start, seeds.end),
        )
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let last = text.lines().rfind(|line| line.starts_with(LOG));
    assert!(
        output.status.success(),
        "{}, {}:\n{}",
        output.status,
        last.unwrap_or("before the first log"),
        String::from_utf8_lossy(&output.stderr)
    );
    let value = |key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key));
        line.unwrap().trim()
    };
    Largest {
        memory_bytes: value("memory_bytes").parse().unwrap(),
        time: Duration::from_millis(value("time_ms").parse().unwrap()),
        longest: value("longest").to_owned(),
    }
}

/// Reads the logs that [`read_all`] names, if it started this process: the body of a test.
///
/// # Panics
/// If a reader panics or takes too long.
pub fn read_mutated() {
    let Ok(range) = std::env::var(FOLDER) else {
        return;
    };
    let mut parts = range.rsplitn(3, ' ');
    let mut number = || parts.next().unwrap().parse().unwrap();
    let (end, start): (u64, u64) = (number(), number());
    let folder = PathBuf::from(parts.next().unwrap());
    let logs = ["a.mcap", "b.mcap"].map(|name| fs::read(folder.join(name)).unwrap());
    let path = folder.join("run.mcap");
    let mut largest = Longest::default();
    for seed in start..end {
        fs::write(&path, mutated(&logs, seed)).unwrap();
        largest = read(&format!("seed {seed}"), &path, &folder).max(largest);
    }
    for name in hostile::write(&folder, &logs[0]).unwrap() {
        let path = folder.join(name).with_extension("mcap");
        largest = read(name, &path, &folder).max(largest);
        fs::remove_file(path).unwrap();
    }
    let (time, name) = largest;
    println!("longest {name}\ntime_ms {}", time.as_millis());
    println!("memory_bytes {}", peak_bytes());
}

/// Time of a way of reading a log, and the names of both.
type Longest = (Duration, String);

/// Reads a log in every way.
fn read(name: &str, path: &Path, folder: &Path) -> Longest {
    // It names the log that ends the process.
    println!("{LOG}{name}");
    let mut longest = Longest::default();
    for (reader, read) in READERS {
        let begun = cpu_time();
        read(path, folder);
        let time = cpu_time().saturating_sub(begun);
        assert!(time < TIME, "{name}: {reader} takes {time:?}");
        longest = longest.max((time, format!("{reader}, {name}")));
    }
    longest
}

/// Time of the processor that all threads of this process have taken, to 10 ms.
fn cpu_time() -> Duration {
    const TICK_MS: u64 = 10;
    let stat = fs::read_to_string("/proc/self/stat").unwrap();
    // Behind the program's name, which may have any characters: user's and system's time.
    let (_, fields) = stat.rsplit_once(')').unwrap();
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks: u64 = ticks.map(|field| field.parse::<u64>().unwrap()).sum();
    Duration::from_millis(ticks * TICK_MS)
}

/// Largest resident memory of this process so far.
fn peak_bytes() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().strip_suffix(" kB"));
    kib.unwrap().parse::<u64>().unwrap() * 1024
}

/// A way of reading the log at the path; the folder is for files. An error is a right answer.
type Read = fn(&Path, &Path);

/// Outcome of each command on a log.
const READERS: [(&str, Read); 6] = [
    ("info", |path, _| {
        if let Ok(info) = Info::read(path) {
            info.table();
            serde_json::to_string(&info).unwrap();
        }
    }),
    ("plot", |path, folder| {
        let Ok(run) = plot::Run::read(path, [None; 2]) else {
            return;
        };
        plot::draw(folder, &Figure::ALL, Formats::ALL, Existing::Number, &[run]).unwrap();
    }),
    ("export", |path, folder| {
        let Ok(head) = Head::read(path, |_| ()) else {
            return;
        };
        for format in [Format::Csv, Format::Parquet, Format::Mat] {
            let out = folder.join(format.extension());
            let rows = || Ok(log::rows(path)?);
            let out = OutputFile::create(&out, Existing::Replace).unwrap();
            export::write(format, out, &head.about(), rows).unwrap();
        }
    }),
    ("replay", |path, _| {
        let Ok(mut reader) = Reader::open(path) else {
            return;
        };
        let mut replayer = Replayer::new(Changes::default()).unwrap();
        let replayed = reader.try_for_each(|event| replayer.take(&event));
        if let Ok(report) = replayed.and_then(|()| replayer.finish()) {
            report.text();
        }
        if let Ok(Some(state)) = reader.go_to_snapshot(u64::MAX)
            && let Ok(Some(mut replayer)) = Replayer::resume(&state, Changes::default())
        {
            let _ = reader.try_for_each(|event| replayer.take(&event));
        }
        if let Ok(raw) = reader.raw() {
            raw.for_each(drop);
        }
    }),
    ("diff", |path, folder| {
        let logs = [path.to_path_buf(), folder.join("a.mcap")];
        if let Ok(diff) = Diff::read(&logs, Align::Drive) {
            diff.table();
        }
    }),
    ("identify", |path, _| {
        let Ok(Log { head, records, .. }) = Log::load(path) else {
            return;
        };
        if let (false, Some(settings)) = (records.is_empty(), head.settings) {
            let mut tally = Tally::default();
            tally.add(&records, &settings);
            let known = KnownParameters::from_setup(&settings.setup);
            let prior = Prior::from_setup(&settings.setup, 0.01);
            let _ = identify(&traces(&records, &settings.setup), &tally, &known, &prior);
        }
        // All events at once, as programs that use the library may read a log.
        let _ = Recording::load(path);
    }),
];

/// A run of a plan.
fn demo() -> Vec<Event> {
    recorded(
        plant([0.30, -0.25], true),
        1,
        Script::demo(Setup::best(), 1_000_000),
    )
}

/// A run with other commands, and a stop.
fn commands() -> Vec<Event> {
    let acts = [
        (150_000, Action::Command(BoardCommand::Arm { session: 0 })),
        (200_000, Action::Command(BoardCommand::Torque([0.1, 0.0]))),
        (
            300_000,
            Action::Command(BoardCommand::Regulate([0.1, -0.1])),
        ),
        (
            400_000,
            Action::Command(BoardCommand::Follow(sinusoid(0.3))),
        ),
        (600_000, Action::Message(ToBoard::Stop)),
        (800_000, Action::Command(BoardCommand::ClearFault)),
    ];
    let host = ScriptedHost::new(acts, 1_000_000);
    tapped_run(host, plant([0.02, 0.0], true), 6, |_, _, _| {})
}

/// Writes the log of these events.
fn record(path: &Path, events: &[Event]) {
    let facts = RunFacts::from_settings("test", "simulated: nothing", &Settings::default());
    let recorder = Recorder::create_waiting(path, &facts).unwrap();
    let (mut tap, mut host, mut board) = (recorder.tap(), Encoder::default(), Encoder::default());
    for event in events {
        match &event.kind {
            EventKind::Sent(_, message) => {
                let frame = host.encode(message).1;
                tap.bytes(Direction::ToBoard, event.host_ns, frame);
            }
            EventKind::Received(_, message) => {
                let frame = board.encode(message).1;
                tap.bytes(Direction::ToHost, event.host_ns, frame);
            }
            EventKind::Lost(..) | EventKind::Damaged(..) => {}
            EventKind::Disconnected => tap.disconnected(event.host_ns),
        }
    }
    recorder.finish().unwrap();
}
