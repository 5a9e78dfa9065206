//! Experiments that a host may send: sound ones, and ones of which some numbers are not.

use armbridge_board::bridge::limits::{MOTION, REFERENCE_MAX_RAD};
use armbridge_control::experiment::{DURATION_MAX_S, TIME_MIN_S};
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::limits::hard;
use armbridge_tests::experiments::{experiment, number};
use armbridge_tests::random::Random;

use super::commands::nasty;

fn sometimes_nasty(random: &mut Random, most: f32) -> f32 {
    if random.once_in(60) {
        let [value] = nasty(random);
        value
    } else {
        number(random, most)
    }
}

/// Mostly one that may be.
pub(super) fn random(random: &mut Random) -> Experiment {
    experiment(random, sometimes_nasty)
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
                Role::Pwm(_) | Role::Bias(_) => f32::from(hard::PWM_COUNTS),
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
