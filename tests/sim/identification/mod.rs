//! Identification on simulated data: diagnosis of defective data, and checks of a fit.
//!
//! Simulated: the virtual arm of the bench, without a bus between, moved by [`tracking_loop`].
//! Lengths and the weight of link 2 are known, as by a ruler and a scale. `arms` covers the
//! whole identification with the board's own plan.

mod arms;
mod bad_data;
mod checks;
mod paper;
mod shipped_plan;
mod tracking_loop;

use core::f64::consts::TAU;

use armbridge_control::actuator::Joint;
use armbridge_control::arm::Parameters;
use armbridge_link::message::Setup;
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantConfig;

/// Prior of the arm: the paper's, but with the true lengths and weight of link 2, as by ruler
/// and scale, and with encoder zeros to some counts, as by calibration.
fn prior_setup(config: &PlantConfig) -> Setup {
    let mut setup = Setup::default();
    setup.arm = Parameters {
        l1: config.arm.l1 as f32,
        l2: config.arm.l2 as f32,
        m2: config.arm.m2 as f32,
        ..setup.arm
    };
    for (joint, servo) in setup.joints.iter_mut().enumerate() {
        servo.direction = config.joints[joint].direction;
        servo.zero_count = config.joints[joint].zero_count as f32 + 3.0;
    }
    setup
}

/// Its servos, as a controller computes with them.
fn servos(setup: &Setup) -> [Joint<f64>; JOINTS] {
    setup.joints.map(|joint| Joint {
        zero_count: joint.zero_count.into(),
        rad_per_count: joint.rad_per_count.into(),
        direction: joint.direction,
        gain_counts_per_nm: joint.gain_counts_per_nm.into(),
        offset_counts: joint.offset_counts.into(),
    })
}

/// Sums of sines, and their slopes.
fn multisine(t: f64, amplitude: f64, lowest_hz: f64, shift: f64) -> [f64; 2] {
    const LINES: u32 = 15;
    let grown = t.min(1.0);
    let mut sum = [0.0; 2];
    for line in 1..=LINES {
        let line = f64::from(line);
        let rate = TAU * lowest_hz * line;
        let phase = rate * t - TAU / 2.0 * line * (line - 1.0) / f64::from(LINES) + shift;
        let amplitude = grown * amplitude / f64::from(LINES).sqrt();
        sum[0] += amplitude * phase.cos();
        sum[1] -= amplitude * rate * phase.sin();
    }
    sum
}
