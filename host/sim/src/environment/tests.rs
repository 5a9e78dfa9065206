//! Tests of the fast board against the exact one.

use armbridge_control::arm::State;
use armbridge_link::message::{Command, Sample, Settings, Setup};
use armbridge_servo::{Firmware, JOINTS};

use super::exact::ExactBoard;
use super::fast::{Delays, FastBoard};
use super::*;
use crate::plant::PlantFile;
use armbridge_client::session::Request;

fn settings() -> Settings {
    Settings {
        setup: Setup::best(),
        ..Settings::default()
    }
}

/// Settings of a board that knows the arm and its servos.
fn settings_for(plant: &PlantConfig) -> Settings {
    let settings = settings();
    Settings {
        setup: plant.board_setup(settings.setup),
        ..settings
    }
}

fn plant(start_rad: [f64; JOINTS]) -> PlantConfig {
    PlantConfig {
        initial: State::at_rest(start_rad.into()),
        ..PlantConfig::default()
    }
}

/// Mean times in µs from the start of a tick to the samples, and to the torque.
fn measured_delays(plant: &PlantConfig) -> [f64; 2] {
    let plant = PlantConfig {
        noise_lsb_rms: 0.0,
        ..*plant
    };
    // A packet to both servos at 1 Mbaud; one of the X series has 20 bytes.
    let packet_us = match plant.firmware() {
        Firmware::Morpheus | Firmware::Stock => 150.0,
        Firmware::XSeries => 200.0,
    };
    let (mut board, _) = ExactBoard::new(&settings_for(&plant), plant, 1).unwrap();
    board.with(|cosim| {
        let joint = plant.joints[0];
        let (mut applied_us, mut late, mut way) = (Vec::new(), 0.0, 0.0);
        // Torques that change with each tick, on an arm that is driven; a servo's period drifts
        // against it by one in a second.
        for tick in 0..10_000_u32 {
            let angle_rad = 0.2 * (f64::from(tick) * 0.02).sin() as f32;
            let command = Command::Regulate([angle_rad, -angle_rad]);
            let now_us = cosim.now_us();
            cosim.host.0.request(now_us, Request::Command(command));
            let start_us = cosim.host.0.status().record.unwrap().input.acts_us();
            let mut before = [0, 1].map(|servo| cosim.bench.applied_pwm(servo));
            while cosim.now_us() < start_us + 1_000 {
                cosim.step_until(cosim.now_us() + 2).unwrap();
                for (servo, before) in before.iter_mut().enumerate() {
                    let pwm = cosim.bench.applied_pwm(servo);
                    if std::mem::replace(before, pwm) != pwm {
                        let after_us = (cosim.now_us() - start_us) as f64;
                        // Before the end of the packet: that of the tick before.
                        let is_earlier = after_us < packet_us;
                        applied_us.push(after_us + if is_earlier { 1_000.0 } else { 0.0 });
                    }
                }
            }
        }
        // A hand moves the arm, not driven, to and fro.
        cosim
            .host
            .0
            .request(cosim.now_us(), Request::Command(Command::Idle));
        for swing in 0..60 {
            let to_rad = if swing % 2 == 0 { 0.8 } else { -0.8 };
            cosim.bench.move_by_hand([to_rad; JOINTS], 400_000);
            let end_us = cosim.now_us() + 400_000;
            while cosim.now_us() < end_us {
                let start_us = cosim.host.0.status().record.unwrap().input.acts_us();
                while cosim.now_us() < start_us {
                    cosim.step_until(start_us).unwrap();
                }
                let state = cosim.bench.state_at(cosim.now_us());
                while cosim.host.0.status().record.unwrap().input.start_us < start_us {
                    cosim.step_until(u64::MAX).unwrap();
                }
                let samples = cosim.host.0.status().record.unwrap().input.samples;
                for servo in 0..JOINTS {
                    let Sample::Counts(counts) = samples[servo] else {
                        panic!("{samples:?}")
                    };
                    let per_s = joint.position(1.0) - joint.position(0.0);
                    let ahead = f64::from(counts) - joint.position(state.q[servo]);
                    late += ahead * per_s * state.dq[servo];
                    way += (per_s * state.dq[servo]).powi(2);
                }
            }
        }
        let applied = applied_us.iter().sum::<f64>() / applied_us.len() as f64;
        [late / way * 1e6, applied]
    })
}

#[test]
fn delays_of_the_fast_board_are_the_means_of_the_exact_one() {
    let start_rad = [0.3, -0.25];
    let x_servos = PlantFile::load("xl430").unwrap().config(start_rad);
    for plant in [plant(start_rad), x_servos] {
        let [sampled_us, applied_us] = measured_delays(&plant);
        let firmware = plant.firmware();
        println!("{firmware}: sampled after {sampled_us:.0} us, applied after {applied_us:.0} us");
        let delays = Delays::of(firmware);
        assert!((sampled_us + delays.sampled_us as f64).abs() < 30.0);
        assert!((applied_us - delays.applied_us as f64).abs() < 30.0);
    }
}

/// Largest distance in counts between the true angles of both boards in 1 s, under the same
/// commands, on arms whose encoders have this noise.
fn distance_counts(noise_lsb_rms: f64, seed: u64, command: impl Fn(u32) -> Command) -> f64 {
    let start_rad = [0.02 * seed as f64, -0.15 - 0.01 * seed as f64];
    let plant = PlantConfig {
        noise_lsb_rms,
        ..plant(start_rad)
    };
    let config = LoopConfig::build(&settings()).unwrap();
    let (mut exact, _) = ExactBoard::new(&settings(), plant, seed).unwrap();
    let (mut fast, _) = FastBoard::new(&config, plant, seed);
    let distances = (0..1_000).map(|tick| {
        let command = command(tick);
        assert!(exact.advance(command, 1).unwrap().is_driven);
        assert!(fast.advance(&command, 1).is_driven);
        (exact.true_state().q - fast.true_state().q).amax()
    });
    distances.fold(0.0, f64::max) * (plant.joints[0].position(1.0) - plant.joints[0].position(0.0))
}

#[test]
fn the_fast_board_is_within_a_count_of_the_exact_one() {
    let upright = |_| Command::Regulate([0.0; JOINTS]);
    let swing = |tick| {
        let angle = (f64::from(tick) * 1e-3 * 6.0).sin() as f32 * 0.2;
        Command::Regulate([angle, -angle])
    };
    // Each reading of an encoder has a noise of its own, and the servos read more often than the
    // fast board: with noise, the two are two draws.
    for (noise, most, median) in [(0.0, 1.0, 0.5), (1.0, 2.0, 1.0)] {
        let distances = (1..=20).flat_map(|seed| {
            [
                distance_counts(noise, seed, upright),
                distance_counts(noise, seed, swing),
            ]
        });
        let mut distances: Vec<f64> = distances.collect();
        distances.sort_by(f64::total_cmp);
        println!(
            "noise {noise}: {:.2} counts at most, median {:.2}",
            distances[39], distances[20]
        );
        assert!(distances[39] < most && distances[20] < median);
    }
}
