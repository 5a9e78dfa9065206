//! Shared by the tests: a run of the bench and measures of its records, hosts and
//! clients of all kinds, boards and servos that are served, scenarios for bench and
//! emulator, and cases of which the campaign has many more.

#![allow(
    clippy::missing_panics_doc,
    clippy::missing_errors_doc,
    reason = "what panics or errs here fails a test"
)]

pub mod board_image;
pub mod cable;
pub mod channel_host;
pub mod command_host;
pub mod endurance;
pub mod experiments;
pub mod fault_campaign;
pub mod kill;
pub mod mutated_logs;
pub mod paper_runs;
pub mod paths;
pub mod random;
pub mod random_arms;
pub mod random_host;
pub mod replay;
pub mod served_board;
pub mod served_servos;
pub mod streams;
pub mod synthetic;
pub mod tapped_bench;
pub mod torque_off;
pub mod trace;
pub mod transparent_port;

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_control::actuator::Joint;
use armbridge_control::arm::State;
use armbridge_control::encoder::Encoder;
use armbridge_link::message::{Controller, Drive, Mode, Record, Setup};
use armbridge_link::motion::Motion;
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_sim::emulator::{EmulatedBoard, Image, Qemu, QemuOptions, Time};
use armbridge_sim::plant::{Plant, PlantConfig};
use nalgebra::Vector2;

/// A virtual arm held at these angles, with or without dry friction.
pub fn plant(initial_rad: [f64; JOINTS], friction_on: bool) -> PlantConfig {
    PlantConfig {
        initial: State::at_rest(Vector2::from(initial_rad)),
        friction_on,
        ..PlantConfig::default()
    }
}

/// The same arm with the encoders of these servos.
pub fn with_encoders(config: PlantConfig, firmware: Firmware) -> PlantConfig {
    let joints = match Encoder::of(firmware) {
        Encoder::Ax12a => config.joints,
        Encoder::XSeries => [Joint::x_series(); JOINTS],
    };
    PlantConfig { joints, ..config }
}

/// The calibrations of servos with this firmware.
pub fn calibrations(firmware: Firmware) -> [Joint<f32>; JOINTS] {
    match Encoder::of(firmware) {
        Encoder::Ax12a => Setup::default().joints,
        Encoder::XSeries => [Joint::x_series(); JOINTS],
    }
}

/// The best set-up with computed torque: each joint's error critically damped at
/// `natural_rad_s`.
pub fn computed_torque(natural_rad_s: f32) -> Setup {
    Setup {
        controller: Controller::ComputedTorque {
            natural_rad_s: [natural_rad_s; JOINTS],
            damping: [1.0; JOINTS],
        },
        ..Setup::best()
    }
}

/// A sinusoid of both joints about upright, at different rates.
pub fn sinusoid(duration_s: f32) -> Motion {
    Motion::Sinusoid {
        centre_rad: [0.0; JOINTS],
        amplitude_rad: [0.2, 0.1],
        frequency_hz: [1.0, 0.7],
        phase_rad: [0.0; JOINTS],
        ramp_s: 0.7,
        duration_s,
    }
}

/// A plan runner at the link of `board`, and the virtual arm on its bus.
pub type Run<B> = Cosim<B, PlanRunner>;

/// A run of `script` on the bench, about to begin. The board's channels are
/// the caller's, as they are a `static` on a real board.
///
/// # Panics
/// If there is no default set-up.
pub fn bench_run(
    channels: &mut Channels,
    config: PlantConfig,
    seed: u64,
    script: Script,
) -> Run<VirtualBoard<'_>> {
    let board = VirtualBoard::new(channels.split()).expect("default set-up");
    Cosim::new(
        board,
        Bench::new(Plant::new(config, seed)),
        PlanRunner::new(script),
    )
}

/// The firmware image under QEMU, in lockstep with the bench; with `icount`, its measured times
/// repeat, too.
///
/// # Panics
/// Without QEMU, or an image of the present source.
pub fn emulated_board(icount: bool) -> EmulatedBoard {
    let options = QemuOptions {
        image: Image::current().expect("an image"),
        time: Time::Lockstep,
        icount,
        provoke: None,
    };
    let qemu = Qemu::start(&options).expect("QEMU");
    EmulatedBoard::new(qemu).expect("a board")
}

/// Works through `script` on the bench; returns the records.
///
/// # Panics
/// If the runner gives up.
pub fn records(config: PlantConfig, seed: u64, script: Script) -> Vec<Record> {
    let mut channels = Channels::new();
    let mut run = bench_run(&mut channels, config, seed, script);
    run.run().expect("a run");
    run.host.into_parts().0
}

/// Asserts that no tick of these was missed, that each has both samples, and that there was no fault.
///
/// # Panics
/// Otherwise.
#[track_caller]
pub fn assert_undisturbed(records: &[Record]) {
    let missed = |record: &Record| record.timing.missed;
    assert_eq!(records.last().map(missed), records.first().map(missed));
    for record in records {
        assert!(!matches!(record.mode, Mode::Fault(_)), "{record:?}");
        let mut samples = record.input.samples.iter();
        assert!(
            samples.all(|sample| sample.counts().is_some()),
            "{record:?}"
        );
    }
}

/// Time in s from the first record in [`Drive::Regulate`] after which joint
/// `joint` stays within `band_rad` of its reference; `None` if it never does.
pub fn settling_s(records: &[Record], joint: usize, band_rad: f32) -> Option<f64> {
    let regulated = || {
        records
            .iter()
            .filter(|record| record.mode.drive() == Some(Drive::Regulate))
    };
    let outside = |record: &&Record| {
        (record.output.angle_rad[joint] - record.output.reference_rad[joint]).abs() >= band_rad
    };
    let first = regulated().next()?;
    let last = regulated().next_back()?;
    let settled_us = match regulated().rfind(outside) {
        Some(outside) if outside.tick == last.tick => return None,
        Some(outside) => outside.input.start_us,
        None => first.input.start_us,
    };
    Some((settled_us - first.input.start_us) as f64 * 1e-6)
}
