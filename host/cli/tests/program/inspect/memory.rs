//! Memory of `plot` on a long log.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use armbridge_client::event::Direction;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{
    Drive, Mode, Record, Sample, Settings, TickInput, TickOutput, ToHost,
};
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;

/// Ticks of the log: ten minutes at 1 kHz.
const TICKS: u32 = 600_000;

/// Largest memory of the program in kB. All ticks in memory would take more by themselves, and
/// an hour takes no more than ten minutes.
const MOST_KB: u64 = 95_000;

/// Writes a log of an arm that swings for ever, with noise on everything.
fn record(path: &Path) {
    let facts = RunFacts::from_settings("long", "simulated: bench", &Settings::default());
    let recorder = Recorder::create_waiting(path, &facts).unwrap();
    let (mut tap, mut encoder) = (recorder.tap(), Encoder::default());
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        (state >> 40) as f32 / (1_u64 << 24) as f32 - 0.5
    };
    let mut frames = Vec::new();
    for tick in 0..TICKS {
        let swing = (tick as f32 * 7e-4).sin();
        let record = Record {
            tick,
            mode: Mode::Running(Drive::Track),
            input: TickInput {
                start_us: u64::from(tick) * 1_000,
                samples: [Sample::Counts((512.0 + 90.0 * swing) as u16); 2],
                pwm_in_force: [(1000.0 + 900.0 * noise()) as u16; 2],
                ..TickInput::AT_REST
            },
            output: TickOutput {
                angle_rad: [swing + 0.01 * noise(), 0.5 * swing + 0.01 * noise()],
                speed_rad_s: [noise(), 3.0 * noise()],
                torque_nm: [noise(), noise()],
                ..TickOutput::NONE
            },
            ..Record::NONE
        };
        frames.extend_from_slice(encoder.encode(&ToHost::Record(record)).1);
        if tick % 100 == 99 {
            let host_ns = u64::from(tick) * 1_000_000;
            tap.bytes(Direction::ToHost, host_ns, &frames);
            frames.clear();
        }
    }
    drop(tap);
    let report = recorder.finish().unwrap();
    assert_eq!((report.records, report.trouble), (u64::from(TICKS), None));
}

#[test]
fn ten_minutes_are_drawn_in_bounded_memory() {
    let folder = super::folder("memory");
    record(&folder.join("run.mcap"));
    let mut program = Command::new(env!("CARGO_BIN_EXE_armbridge"))
        .args(["plot", "run.mcap"])
        .current_dir(&folder)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    // The largest so far, by the kernel: the last look is just before the end.
    let status = format!("/proc/{}/status", program.id());
    let mut most_kb = 0;
    while program.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kb = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
        most_kb = most_kb.max(kb.unwrap_or(0));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(program.wait().unwrap().success());
    assert!((1..MOST_KB).contains(&most_kb), "{most_kb} kB");
    fs::remove_file(folder.join("run.mcap")).unwrap();
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 14);
}
