//! Arms that are pushed, thrown, held, and whose encoder freezes, while they float.

use super::led::{MS, Seen, float_with, part, setups};
use super::{COUNT_RAD, Lead, hidden, lead};
use armbridge_link::message::{Fault, Mode};
use armbridge_servo::JOINTS;
use armbridge_sim::faults::sensor::SensorFault;
use armbridge_sim::plant::{LeadPoint, Push};

/// Time at which the arm has been weighed, in ms.
const WEIGHED_MS: u64 = 2_000;

fn fastest(seen: &[Seen]) -> f64 {
    seen.iter()
        .map(|seen| seen.state.dq.amax())
        .fold(0.0, f64::max)
}

/// A tenth of a second of 0.3 N m, and a throw of 0.8 N m: once the push is over no arm gets
/// faster, and it comes to rest.
#[test]
fn a_push_and_a_throw_die_away() {
    for (name, base) in setups() {
        for (torque_nm, seeds) in [(0.3, 1..=20), (-0.8, 21..=40)] {
            for seed in seeds {
                let (mut config, setup) = hidden(seed, base);
                // A throw from upright ends before the angle limits.
                config.initial.q *= 0.3;
                let seen = float_with(&config, setup, seed, 6_000, |bench| {
                    for joint in 0..JOINTS {
                        bench.push(Push {
                            joint,
                            torque_nm,
                            start_ns: WEIGHED_MS * MS,
                            duration_ns: 100 * MS,
                        });
                    }
                });
                let (seen, mode) = (seen.seen, seen.mode);
                assert!(
                    matches!(mode, Mode::Running(_)),
                    "{name}, seed {seed}: {mode:?}"
                );
                let free = part(&seen, WEIGHED_MS + 100, 6_000);
                let (first, most) = (free[0].state.dq.amax(), fastest(free));
                assert!(first > 0.3, "{name}, seed {seed}: pushed to {first} rad/s");
                assert!(
                    most < first + 0.05,
                    "{name}, seed {seed}: {first}, then {most} rad/s"
                );
                let last = fastest(part(&seen, 5_000, 6_000));
                assert!(last < 0.05, "{name}, seed {seed}: still {last} rad/s");
            }
        }
    }
}

/// A hand that holds the arm 0.02 rad away from where it stays, for three seconds, and lets go:
/// what the arm held against it moves it by a few counts.
#[test]
fn an_arm_that_was_held_stays_near_the_hand() {
    for (name, base) in setups() {
        for seed in 1..=20 {
            let (config, setup) = hidden(seed, base);
            let start_ns = WEIGHED_MS * MS;
            let away = config.initial.q.map(|q| q + 0.02).into();
            let hand = Lead {
                path: vec![LeadPoint {
                    after_ns: 200 * MS,
                    angle_rad: away,
                }],
                ..lead(start_ns, &[], 3_000 * MS)
            };
            let seen = float_with(&config, setup, seed, 8_000, |bench| bench.lead(&hand));
            let free = part(&seen.seen, WEIGHED_MS + 3_000, 8_000);
            for joint in 0..JOINTS {
                let way = free[free.len() - 1].state.q[joint] - free[0].state.q[joint];
                let counts = way.abs() / COUNT_RAD;
                assert!(
                    counts < 8.0,
                    "{name}, seed {seed}, joint {joint}: {counts} counts"
                );
            }
            assert!(
                fastest(free) < 0.2,
                "{name}, seed {seed}: {}",
                fastest(free)
            );
        }
    }
}

/// A hand that leads the arm, pauses for 0.8 s and goes on: the arm does not resist it more than
/// before.
#[test]
fn a_pause_makes_no_resistance() {
    for (name, base) in setups() {
        for seed in 1..=20 {
            let (config, setup) = hidden(seed, base);
            let initial: [f64; JOINTS] = config.initial.q.into();
            let away = initial.map(|q| q - 0.4 * q.signum());
            let point = |after_ms: u64, angle_rad| LeadPoint {
                after_ns: after_ms * MS,
                angle_rad,
            };
            let start_ns = WEIGHED_MS * MS;
            let hand = Lead {
                path: vec![
                    point(1_200, away),
                    point(2_000, away),
                    point(3_200, initial),
                ],
                ..lead(start_ns, &[], 3_200 * MS)
            };
            let seen = float_with(&config, setup, seed, 7_000, |bench| bench.lead(&hand));
            let most = |from_ms: u64| {
                let part = part(
                    &seen.seen,
                    WEIGHED_MS + from_ms,
                    WEIGHED_MS + from_ms + 1_100,
                );
                part.iter()
                    .map(|seen| seen.hand_nm.amax())
                    .fold(0.0, f64::max)
            };
            let (before, after) = (most(50), most(2_050));
            assert!(
                after < before + 0.12,
                "{name}, seed {seed}: {before}, then {after} N m"
            );
        }
    }
}

/// An encoder that freezes while a hand leads the arm is found before the hand lets go.
#[test]
fn an_encoder_that_freezes_ends_it() {
    for (name, base) in setups() {
        for seed in 1..=20 {
            let (config, setup) = hidden(seed, base);
            let to = config.initial.q.map(|q| q - 0.5 * q.signum()).into();
            let hand = lead(WEIGHED_MS * MS, &[to], 3_000 * MS);
            let servo = (seed % 2) as usize;
            let seen = float_with(&config, setup, seed, 2_600, |bench| {
                bench.lead(&hand);
                bench.fail_sensor(servo, SensorFault::Frozen);
            });
            assert_eq!(
                seen.mode,
                Mode::Fault(Fault::EncoderFrozen),
                "{name}, seed {seed}"
            );
        }
    }
}
