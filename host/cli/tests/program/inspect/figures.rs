//! Numbers in figures: they are those of the summary, and of `diff`.

use std::fs;
use std::path::Path;

use armbridge_client::event::Direction;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Drive, Mode, Record, Settings, TickInput, TickOutput, ToHost};
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use serde_json::Value;

use super::folder;
use super::program::{difference, json, printed};

/// Ticks of a log: 100 s at 1 kHz, more than a figure keeps in memory.
const TICKS: u32 = 100_000;

#[test]
fn the_settling_in_a_plot_is_that_of_the_summary() {
    let folder = folder("settling");
    let summary = json(&folder, &["run", "demo", "--json"], 0);
    let run = folder.join(summary["folder"].as_str().unwrap());
    printed(
        &folder,
        &["plot", "--format", "svg", "--what", "angles,tracking"],
        0,
    );
    let angles = fs::read_to_string(run.join("angles.svg")).unwrap();
    let tracking = fs::read_to_string(run.join("tracking.svg")).unwrap();
    let segments = summary["segments"].as_array().unwrap();
    assert_eq!(segments.len(), 3);
    for joint in segments
        .iter()
        .flat_map(|segment| segment["joints"].as_array().unwrap())
    {
        let settling_s = joint["settling_time_s"].as_f64().unwrap();
        // The baseline of the demo is behind it, and only times are written.
        for (svg, text) in [
            (&angles, format!(">{settling_s:.2} s<")),
            (&tracking, format!(">settled in {settling_s:.2} s, rests ")),
        ] {
            assert!(svg.contains(&text), "no {text:?} in\n{}", texts(svg));
        }
    }
}

/// Texts of a drawing, one a line.
fn texts(svg: &str) -> String {
    let texts = svg.split("<text").skip(1);
    let text = |text: &str| Some(text.split('>').nth(1)?.split('<').next()?.to_owned());
    texts.filter_map(text).collect::<Vec<_>>().join("\n")
}

/// Writes a log of an arm that comes to rest from this far off, with noise.
fn record(folder: &Path, seed: u64, from_rad: f32) {
    let facts = RunFacts::from_settings("long", "simulated: bench", &Settings::default());
    fs::create_dir_all(folder).unwrap();
    let recorder = Recorder::create_waiting(&folder.join("run.mcap"), &facts).unwrap();
    let (mut tap, mut encoder) = (recorder.tap(), Encoder::default());
    let mut state = seed;
    let mut noise = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        (state >> 40) as f32 / (1_u64 << 24) as f32 - 0.5
    };
    for tick in 0..TICKS {
        let error_rad = from_rad * (tick as f32 * -1e-4).exp();
        let record = Record {
            tick,
            mode: Mode::Running(Drive::Regulate),
            input: TickInput {
                start_us: u64::from(tick) * 1_000,
                ..TickInput::AT_REST
            },
            output: TickOutput {
                angle_rad: [
                    error_rad + 0.002 * noise(),
                    0.5 * error_rad + 0.002 * noise(),
                ],
                torque_nm: [noise(), noise()],
                ..TickOutput::NONE
            },
            ..Record::NONE
        };
        let frame = encoder.encode(&ToHost::Record(record)).1;
        tap.bytes(Direction::ToHost, record.input.start_us * 1_000, frame);
    }
    drop(tap);
    let report = recorder.finish().unwrap();
    assert_eq!((report.records, report.trouble), (u64::from(TICKS), None));
}

/// Root mean square of the difference of each angle over all ticks, in mrad.
fn rms_mrad(diff: &Value) -> [f64; 2] {
    ["angle_rad_1", "angle_rad_2"].map(|column| 1e3 * difference(&diff["runs"][0], column)[1])
}

#[test]
fn rms_values_of_long_runs_are_those_of_all_their_ticks() {
    let folder = folder("rms");
    for (name, seed, from_rad) in [("a", 1, 0.1), ("b", 2, 0.3)] {
        record(&folder.join(name), seed, from_rad);
    }
    let args = [
        "plot",
        "a",
        "b",
        "--what",
        "difference,tracking",
        "--format",
        "svg",
    ];
    printed(&folder, &[&args[..], &["--out", "plots"]].concat(), 0);
    let [joint_1, joint_2] = rms_mrad(&json(&folder, &["diff", "a", "b", "--json"], 1));
    let svg = fs::read_to_string(folder.join("plots/compare-difference.svg")).unwrap();
    let text = format!("minus the first: rms {joint_1:.1} and {joint_2:.1} mrad");
    assert!(svg.contains(&text), "no {text:?} in\n{}", texts(&svg));

    let svg = fs::read_to_string(folder.join("plots/compare-tracking.svg")).unwrap();
    for from_rad in [0.1, 0.3] {
        // Noise is uniform, 2 mrad wide; the exponential's squares are summed over all ticks.
        let sum: f64 = (0..TICKS).map(|tick| (-2e-4 * f64::from(tick)).exp()).sum();
        let square = 1e6 * from_rad * from_rad * sum / f64::from(TICKS);
        let [joint_1, joint_2] = [1.0, 0.25].map(|share| f64::sqrt(share * square + 4.0 / 12.0));
        let text = format!("rms {joint_1:.1} and {joint_2:.1} mrad");
        assert!(svg.contains(&text), "no {text:?} in\n{}", texts(&svg));
    }
    fs::remove_dir_all(&folder).unwrap();
}
