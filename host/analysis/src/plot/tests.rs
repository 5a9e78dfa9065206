//! Runs as they are read for figures, of logs made tick by tick.

use armbridge_link::message::{
    Drive, Mode, Record, Sample, Settings, TickInput, TickOutput, Timing,
};
use armbridge_log::record_values::error_rad;
use armbridge_log::run_info::RunFacts;
use armbridge_log::simulation::Push;

use super::Run;
use crate::test_log::write_log;

/// Start of the first tick in µs.
const FIRST_US: u64 = 17_000;
/// Ticks of bring-up, each of 1 ms.
const BRING_UP: u32 = 300;

const PUSH: Push = Push {
    joint: 0,
    torque_nm: 0.5,
    start_ns: 2_317_000_000,
    duration_ns: 200_000_000,
};

fn tick(tick: u32, mode: Mode, error_rad: f32) -> Record {
    Record {
        tick,
        mode,
        timing: Timing {
            bus_us: 500,
            ..Record::NONE.timing
        },
        input: TickInput {
            start_us: FIRST_US + 1_000 * u64::from(tick),
            samples: [Sample::Counts(512); 2],
            ..TickInput::AT_REST
        },
        output: TickOutput {
            angle_rad: [error_rad, 0.1],
            reference_rad: [0.0, 0.1],
            ..TickOutput::NONE
        },
        ..Record::NONE
    }
}

/// Bring-up, then 4 s about a setpoint, which joint 1 reaches after 0.5 s and from which it is
/// pushed after 2 s.
fn pushed() -> Vec<Record> {
    let bring_up = (0..BRING_UP).map(|at| tick(at, Mode::Idle, 0.1));
    let error_rad = |at: u32| {
        if at < 500 || (2_000..2_300).contains(&at) {
            0.1
        } else {
            0.0
        }
    };
    let mode = Mode::Running(Drive::Regulate);
    let held = (0..4_000).map(|at| tick(BRING_UP + at, mode, error_rad(at)));
    bring_up.chain(held).collect()
}

#[test]
fn a_push_that_is_in_the_log_before_earlier_ticks_counts_from_its_start() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    write_log(&path, &[PUSH], &pushed());
    let run = Run::read(&path, [None; 2]).unwrap();
    let joints = &run.intervals[0].joints;
    assert_eq!(
        joints[0].settling_time_s.map(|s| (s * 1e3).round()),
        Some(500.0)
    );
    let at_ms: Vec<f64> = run
        .marks
        .iter()
        .map(|mark| (mark.time_s * 1e3).round())
        .collect();
    assert_eq!(at_ms, [2_000.0]);
}

#[test]
fn without_a_closed_loop_there_is_no_reference_and_no_error() {
    let facts = RunFacts::from_settings("t", "simulated: bench", &Settings::default());
    for drive in [Drive::Torque, Drive::Experiment, Drive::Float] {
        let swing = |at: u32| (at as f32 * 0.1).sin();
        let records = (0..2_000).map(|at| Record {
            output: TickOutput {
                torque_nm: [swing(at); 2],
                ..tick(at, Mode::Running(drive), swing(at)).output
            },
            ..tick(at, Mode::Running(drive), swing(at))
        });
        let run = Run::of_records(&facts, &records.collect::<Vec<_>>());
        assert!(
            run.records().all(|record| error_rad(record, 0).is_nan()),
            "{drive:?}"
        );
        assert!(run.reference_curve.is_empty(), "{drive:?}");
        let has_spectrum: Vec<bool> = run
            .spectra
            .iter()
            .map(|joints| joints[0].is_some())
            .collect();
        assert_eq!(has_spectrum, [false, true, true], "{drive:?}");
    }
}

#[test]
fn everything_of_a_figure_begins_where_its_interval_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    // The arm swings wide during bring-up.
    let mut records = pushed();
    for (at, record) in records.iter_mut().enumerate().take(BRING_UP as usize) {
        record.output.angle_rad[0] = 1.0 - at as f32 * 1e-3;
    }
    write_log(&path, &[], &records);
    for (from_s, ticks) in [
        (None, 4_000),
        (Some(-0.1005), 4_100),
        (Some(-9.0), 4_300),
        (Some(0.9995), 3_000),
    ] {
        let run = Run::read(&path, [from_s, None]).unwrap();
        assert_eq!(
            (run.shown, run.ticks.len()),
            (ticks, ticks as usize),
            "{from_s:?}"
        );
        let counted: u64 = run.timing[1].iter().map(|(_, count)| count).sum();
        assert_eq!(counted, ticks, "{from_s:?}");
        let widest =
            |curve: &super::run::Curve| curve.iter().flatten().map(|p| p.0).fold(0.0, f64::max);
        let expected = match from_s {
            Some(from_s) if from_s < -1.0 => 1.0,
            Some(from_s) if from_s < 0.0 => 0.8,
            _ => 0.1,
        };
        for curve in [&run.phase[0], &run.path_curve] {
            assert!(
                (widest(curve) - expected).abs() < 1e-6,
                "{from_s:?}: {}",
                widest(curve)
            );
        }
        // Setpoints are those of the whole run.
        assert_eq!(run.intervals.len(), 1);
        assert!(run.intervals[0].start_s.abs() < 1e-9);
    }
}
