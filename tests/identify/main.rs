//! Identification finds arms that were drawn at random.
//!
//! Simulated: the virtual arm of the bench, without a bus between. Its numbers are up to
//! 40 % off what is believed, each by itself; noise is a count; it has a dead zone, delay
//! and dry friction. Lengths and the weight of link 2 are told, as by a ruler and a
//! scale.

mod bad_data;
mod checks;
mod hands;

use armbridge::bench::plant::PlantConfig;
use armbridge::identify::{Found, Known, Prior, Quantity, Tally, identify};
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Joint;
use armbridge_shared::arm::Parameters;
use armbridge_shared::link::message::Setup;
use core::f64::consts::TAU;

use hands::{Hands, LEAD_S};

/// What the arm is believed to be: the paper's, but for what a ruler tells, the weight of
/// link 2, and where its zeros are, which calibration has found to some counts.
fn believed(config: &PlantConfig) -> Setup {
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

/// Two minutes: everything that has to be seen is moved.
fn experiments(hands: &mut Hands) {
    hands.go([0.0, 0.0]);
    hands.track(30.0, |t| {
        [multisine(t, 0.25, 0.1, 0.0), multisine(t, 0.3, 0.13, 1.0)]
    });
    let slow = |t: f64, amplitude: f64, hz: f64| {
        let (sin, cos) = (TAU * hz * t).sin_cos();
        let amplitude = amplitude * (t / 2.0).min(1.0);
        [amplitude * sin, amplitude * TAU * hz * cos]
    };
    hands.track(20.0, |t| [slow(t, 0.5, 0.2), slow(t, 0.7, 0.27)]);
    // Falls through the dead zone, again and again.
    let triangle = |t: f64, _| 1000.0 + 80.0 * (2.0 * (2.0 * (2.0 * t).fract() - 1.0).abs() - 1.0);
    for way in [1.0, -1.0, 1.0, -1.0] {
        hands.go([0.35 * way, 0.0]);
        hands.let_go(0, 1.5, 0.75, triangle);
        hands.go([0.0, 0.6 * way]);
        hands.let_go(1, 1.5, 0.6, triangle);
    }
    // Held, and then more and more, or less and less.
    for way in [1.0, -1.0, 1.0, -1.0] {
        for ramp in [120.0, -120.0] {
            hands.go([0.5 * way, 0.0]);
            hands.let_go(0, 3.0, 0.12, |t, held| held + ramp * t);
            hands.go([0.0, way]);
            hands.let_go(1, 3.0, 0.12, |t, held| held + ramp * t);
        }
    }
}

/// What was found, and how far it is off in standard errors and as a share.
struct Judged {
    found: Found,
    off: Vec<(usize, Quantity, f64, f64)>,
}

fn judge(seed: u64) -> Judged {
    let config = PlantConfig::drawn(seed, 0.4);
    let setup = believed(&config);
    let mut hands = Hands::on(&config, servos(&setup), seed);
    experiments(&mut hands);
    let known = Known {
        lead_s: LEAD_S,
        ..Known::of(&setup)
    };
    let mut prior = Prior::of(&setup, 0.001);
    // Link 1 was not weighed.
    prior.deviation[Quantity::Gravity.at(0)] = 1.0;
    let traces = [hands.trace];
    let found = identify(&traces, &Tally::of_traces(&traces), &known, &prior).unwrap();
    let mut truth = setup;
    truth.arm = config.arm.map(|number| number as f32);
    for joint in 0..JOINTS {
        truth.joints[joint].zero_count = config.joints[joint].zero_count as f32;
        truth.joints[joint].gain_counts_per_nm = config.joints[joint].gain_counts_per_nm as f32;
        truth.joints[joint].offset_counts = config.joints[joint].offset_counts as f32;
        truth.friction_nm[joint] = config.friction[joint].coulomb_nm as f32;
    }
    let mut off = Vec::new();
    for joint in 0..JOINTS {
        for quantity in Quantity::ALL {
            let true_value = match quantity {
                Quantity::DeadBelow => config.dead_zone_counts[joint][0].into(),
                Quantity::DeadAbove => config.dead_zone_counts[joint][1].into(),
                Quantity::Delay => config.input_delay_ns[joint] as f64 * 1e-9,
                Quantity::Inertia
                | Quantity::Gravity
                | Quantity::Viscous
                | Quantity::Coulomb
                | Quantity::Gain
                | Quantity::Offset
                | Quantity::Zero => quantity.of(&truth, joint),
            };
            let (value, error) = found.number(joint, quantity);
            let sigmas = (value - true_value) / error;
            off.push((joint, quantity, sigmas, value / true_value - 1.0));
        }
    }
    Judged { found, off }
}

#[test]
fn arms_drawn_at_random_are_found_with_their_errors() {
    let (mut within, mut all) = (0, 0);
    for seed in 1..=3 {
        let Judged { found, off } = judge(seed);
        assert!(
            found.odd() * 20 < found.stretches.len(),
            "{seed}: {}",
            found.odd()
        );
        assert!(
            (1.0..1.1).contains(&found.noise_counts),
            "{seed}: {}",
            found.noise_counts
        );
        for (joint, quantity, sigmas, share) in off {
            let what = format!("arm {seed}, joint {joint}, {quantity:?}: {sigmas:.1}, {share:.3}");
            println!("{what}");
            assert!(sigmas.abs() < 4.0, "{what}");
            // What a controller lives on; the rest is judged by its own errors alone.
            let matters = matches!(
                quantity,
                Quantity::Inertia
                    | Quantity::Gravity
                    | Quantity::Viscous
                    | Quantity::Coulomb
                    | Quantity::Gain
                    | Quantity::Zero
            );
            assert!(!matters || share.abs() < 0.08, "{what}");
            within += usize::from(sigmas.abs() < 1.96);
            all += 1;
        }
    }
    println!("{within} of {all} within their 95 % interval");
    assert!(within * 10 >= all * 9, "{within} of {all}");
}
