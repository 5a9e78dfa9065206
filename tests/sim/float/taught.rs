//! Motions that a hand has taught, replayed on the same arm.

use super::led::{MS, float_with, setups};
use super::{COUNT_RAD, hidden, lead};
use armbridge_analysis::plan_runner::plan::{InitialSettings, Plan};
use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_analysis::taught_motion::{SPACING_S, TaughtMotion};
use armbridge_board::bridge::Channels;
use armbridge_control::actuator::Direction;
use armbridge_control::arm::State;
use armbridge_link::message::{Drive, Record, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_sim::plant::{Plant, PlantConfig};
use core::mem::replace;
use nalgebra::Vector2;
use std::path::Path;

/// Angles of an arm as a board with these joints reads them, without noise.
fn read(config: &PlantConfig, setup: &Setup, q: Vector2<f64>) -> [f64; JOINTS] {
    core::array::from_fn(|joint| {
        let known = setup.joints[joint];
        let off = config.joints[joint].position(q[joint]) - f64::from(known.zero_count);
        let angle = off * f64::from(known.rad_per_count);
        match known.direction {
            Direction::Forward => angle,
            Direction::Reverse => -angle,
        }
    })
}

/// Sum of squares of each joint, and their number.
#[derive(Default)]
struct Squares([f64; JOINTS], u32);

impl Squares {
    fn add(&mut self, a: [f64; JOINTS], b: [f64; JOINTS]) {
        for joint in 0..JOINTS {
            self.0[joint] += (a[joint] - b[joint]).powi(2);
        }
        self.1 += 1;
    }

    /// Root of the mean, in counts.
    fn counts(&self) -> [f64; JOINTS] {
        assert!(self.1 > 100, "{} values", self.1);
        self.0
            .map(|sum| (sum / f64::from(self.1)).sqrt() / COUNT_RAD)
    }
}

/// Distance of the arm from the reference while it follows the motion, in counts rms.
fn replayed(
    config: &PlantConfig,
    setup: &Setup,
    seed: u64,
    csv: &str,
    speed: f64,
) -> [f64; JOINTS] {
    let overrides = Overrides {
        speed: Some(speed),
        ..Overrides::default()
    };
    let scenario = Scenario::parse(Path::new("taught.csv"), csv, &overrides).unwrap();
    let mut settings = scenario.settings;
    // The board knows which way the servos turn.
    settings.setup.joints = setup.joints;
    settings.limits = Script::limits();
    let plan = Plan {
        begin: InitialSettings::Fixed(Box::new(settings)),
        ..scenario.plan
    };
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = Bench::new(Plant::new(*config, seed));
    let mut run = Cosim::new(board, bench, PlanRunner::new(plan));
    let (mut squares, mut seen) = (Squares::default(), 0);
    let mut before = [0.0; JOINTS];
    while run.host.ending().is_none() {
        run.step().unwrap();
        let records = run.host.records();
        let Some(record) = records.last().filter(|_| records.len() > seen) else {
            continue;
        };
        seen = records.len();
        // The reference is that of the next tick, in which this record arrives.
        let reference = replace(&mut before, record.output.reference_rad.map(f64::from));
        let moves = record
            .output
            .reference_speed_rad_s
            .iter()
            .any(|speed| speed.abs() > 0.0);
        if record.mode.drive() == Some(Drive::Track) && moves {
            let q = run
                .bench
                .state_at(record.input.start_us.max(run.now_us()))
                .q;
            squares.add(read(config, setup, q), reference);
        }
    }
    squares.counts()
}

/// Ten hidden arms, led by a hand at 0.25 rad/s: the path that is kept is within a count of the
/// one that was led, and replays are within three counts rms of it, up to twice as fast.
#[test]
fn a_taught_motion_is_replayed() {
    let (_, base) = setups()[1];
    let mut worst = [0.0_f64; 4];
    for seed in 1..=10 {
        let (mut config, setup) = hidden(seed, base);
        config.initial.q *= 0.8;
        let initial: [f64; JOINTS] = config.initial.q.into();
        let turned = |by: f64| initial.map(|q| q - by * q.signum());
        let mut hand = lead(
            2_000 * MS,
            &[turned(0.5), turned(0.1), turned(0.7)],
            8_000 * MS,
        );
        for point in &mut hand.path {
            point.after_ns *= 2;
        }
        let led = float_with(&config, setup, seed, 12_000, |bench| bench.lead(&hand));
        let taught = TaughtMotion::from_records(&led.records).unwrap();
        let floats = |record: &&Record| record.mode.drive() == Some(Drive::Float);
        let first = led.records.iter().find(floats).unwrap();
        let mut kept = Squares::default();
        for (number, angle_rad) in taught.angle_rad.iter().enumerate() {
            let after_s = taught.cut_s[0] + number as f64 * SPACING_S;
            let at_us = first.input.start_us + (after_s * 1e6) as u64;
            let q = led.seen[(at_us / 2_000) as usize].state.q;
            kept.add(read(&config, &setup, q), *angle_rad);
        }
        let start = PlantConfig {
            initial: State::at_rest(led.seen[0].state.q),
            ..config
        };
        let csv = taught.csv();
        let rows = [0.5, 1.0, 2.0].map(|speed| replayed(&start, &setup, seed, &csv, speed));
        let kept = kept.counts();
        println!(
            "seed {seed}: {:.2} s, kept within {kept:.2?}, replayed within {rows:.2?} counts rms",
            taught.duration_s()
        );
        for (worst, row) in worst.iter_mut().zip([kept, rows[0], rows[1], rows[2]]) {
            *worst = worst.max(row[0]).max(row[1]);
        }
    }
    println!("kept, and replayed at 0.5, 1 and 2 times the speed: {worst:.2?} counts at most");
    let [kept, _, same, twice] = worst;
    assert!(kept < 1.5 && same < 1.5 && twice < 3.0, "{worst:?}");
}
