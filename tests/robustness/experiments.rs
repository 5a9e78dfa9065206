//! Experiments that a host may send: sound ones, and ones of which some numbers are not.

use armbridge_shared::bridge::limits::{MOTION, REFERENCE_MAX_RAD};
use armbridge_shared::experiment::{DURATION_MAX_S, Signal, TIME_MIN_S};
use armbridge_shared::link::experiment::{Experiment, Role};
use armbridge_shared::link::limits::hard;
use armbridge_tests::random::Random;

use super::commands::nasty;

fn sometimes_nasty(random: &mut Random, sound: f32) -> f32 {
    if random.once_in(60) {
        let [value] = nasty(random);
        value
    } else {
        sound * (random.below(1_000) as f32 * 1e-3)
    }
}

fn signal(random: &mut Random, most: f32) -> Signal<f32> {
    let mut number = |sound: f32| sometimes_nasty(random, sound);
    let [a, b, time_s, ramp_s, hz] = [
        number(most * 0.5),
        number(most * 0.5),
        0.01 + number(0.3),
        number(0.1),
        number(3.0),
    ];
    let steps = random.below(20) as u8;
    match random.below(8) {
        0 => Signal::Constant(a),
        1 => Signal::Triangle {
            offset: a,
            amplitude: b,
            period_s: time_s,
        },
        2 => Signal::Staircase {
            from: a,
            to: -b,
            steps,
            dwell_s: time_s,
        },
        3 => Signal::Steps {
            first: a,
            increment: b * 0.05,
            steps,
            on_s: time_s,
            off_s: ramp_s,
            alternating: random.once_in(2),
        },
        4 => Signal::Sinusoid {
            offset: a,
            amplitude: b,
            frequency_hz: hz,
            ramp_s,
        },
        5 => Signal::Chirp {
            offset: a,
            amplitude: b,
            from_hz: hz,
            to_hz: time_s,
            ramp_s,
        },
        6 => Signal::Multisine {
            amplitude: b,
            lowest_hz: hz,
            lines: steps,
            ramp_s,
        },
        _ => Signal::Prbs {
            amplitude: b,
            hold_s: time_s,
            seed: random.below(1 << 32) as u32,
        },
    }
}

/// Mostly one that may be.
pub(super) fn random(random: &mut Random) -> Experiment {
    let roles = [(); 2].map(|()| match random.below(5) {
        0 => Role::Off,
        1 => Role::Hold,
        2 => Role::Pwm(signal(random, 500.0)),
        3 => Role::Torque(signal(random, 0.6)),
        _ => Role::Angle(signal(random, 0.05)),
    });
    let mut experiment = Experiment {
        roles,
        duration_s: 0.2 + random.below(2_000) as f32 * 1e-3,
        angle_rad: [[-0.6, 0.6]; 2],
        speed_rad_s: [2.5; 2],
    };
    if random.once_in(4) {
        experiment.angle_rad = [nasty(random), nasty(random)];
    }
    if random.once_in(8) {
        experiment.speed_rad_s = nasty(random);
        [experiment.duration_s] = nasty(random);
    }
    experiment
}

/// Whether a board may accept it at all: of what it asks, nothing is beyond what any arm
/// is allowed, sampled and not by its own bounds.
pub(super) fn is_acceptable(plan: &Experiment) -> bool {
    let duration_s = plan.duration_s;
    let lasts = duration_s >= TIME_MIN_S as f32 && duration_s <= DURATION_MAX_S as f32;
    let envelope_is_one = plan
        .angle_rad
        .iter()
        .zip(plan.speed_rad_s)
        .all(|(edges, speed)| {
            let [low, high] = *edges;
            low < high
                && edges.iter().all(|edge| edge.abs() <= hard::ANGLE_RAD)
                && (0.0..=hard::SPEED_RAD_S).contains(&speed)
        });
    lasts
        && envelope_is_one
        && plan.roles.iter().all(|role| {
            let most = match role {
                Role::Off | Role::Hold => return true,
                Role::Pwm(_) => f32::from(hard::PWM_COUNTS),
                Role::Torque(_) => hard::TORQUE_NM,
                Role::Angle(_) => 2.0 * REFERENCE_MAX_RAD,
            };
            let signal = role.signal().expect("one of those with a signal");
            (0..=200_u8).all(|i| {
                let sample = signal.at(duration_s * f32::from(i) / 200.0, duration_s);
                let is_smooth = sample.first.abs() <= MOTION.speed_rad_s * 1.001
                    && sample.second.abs() <= MOTION.acceleration_rad_s2 * 1.001;
                sample.value.abs() <= most * 1.001 && (is_smooth || !matches!(role, Role::Angle(_)))
            })
        })
}
