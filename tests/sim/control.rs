//! Control quality: the best set-up, on the whole bench, judged by the true motion of the arm.
//!
//! The default arm has everything that is in a controller's way: static friction
//! of 0.06 N m and 0.04 N m sliding, angles in counts of 5.1 mrad with one count
//! of noise, a PWM in integers, a torque that acts a period late. The bounds here
//! are what is promised; the figures measured are well inside.

use std::fmt::Debug;

use armbridge_analysis::monte_carlo::{Joints, Maneuver, Outcome, Trial, for_seeds};
use armbridge_control::actuator::Joint;
use armbridge_control::estimate::{Config, Tuning};
use armbridge_link::message::{Controller, Gains, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{PlantConfig, Push};
use armbridge_tests::{computed_torque, plant};

/// Where the arm is let go: 28 degrees off, three fifths of what torque can hold.
const INITIAL_RAD: [f64; JOINTS] = [0.49, -0.3];

/// The default arm.
fn arm() -> PlantConfig {
    plant(INITIAL_RAD, true)
}

fn trial(config: &PlantConfig, setup: Setup, task: &str, duration_s: f64) -> Trial {
    let task: Maneuver = task.parse().unwrap();
    Trial::new(*config, task.script(setup, duration_s).unwrap())
}

/// The outcomes of these seeds, none of which may end in a fault.
fn outcomes(trial: &Trial, seeds: std::ops::RangeInclusive<u64>) -> Vec<Outcome> {
    let seeds: Vec<u64> = seeds.collect();
    let one = |seed| {
        trial
            .run(seed)
            .map(|run| Outcome::from_run(trial, seed, &run))
    };
    let outcomes = for_seeds(&seeds, one, |_| ()).unwrap();
    for outcome in &outcomes {
        assert_eq!(outcome.fault, None, "{outcome:?}");
        assert_eq!(outcome.missed_ticks, 0, "{outcome:?}");
    }
    outcomes
}

#[track_caller]
fn at_most(limit: f64, figures: Joints, of: &impl Debug) {
    assert!(
        figures.iter().all(|x| x.abs() <= limit),
        "{figures:?} > {limit}: {of:?}"
    );
}

#[track_caller]
fn within(limit_s: f64, time_s: Option<f64>, of: &impl Debug) {
    assert!(
        time_s.is_some_and(|s| s < limit_s),
        "{time_s:?}, not < {limit_s} s: {of:?}"
    );
}

#[test]
fn stands_within_a_milliradian() {
    for outcome in outcomes(&trial(&arm(), Setup::best(), "upright", 8.0), 1..=20) {
        within(1.2, outcome.settling_time_s, &outcome);
        at_most(1.0, outcome.mean_error_mrad, &outcome);
        at_most(1.5, outcome.rms_error_mrad, &outcome);
        at_most(5.0, outcome.peak_to_peak_mrad, &outcome);
        at_most(0.05, outcome.torque_rms_nm, &outcome);
        at_most(0.06, outcome.speed_error_rms_rad_s, &outcome);
    }
}

/// Inertia, gravity and motors 20 % off what the controller believes, both ways.
#[test]
fn an_arm_that_is_not_the_model_stands() {
    for corner in 0..8_u8 {
        let scale = |bit: u8| if corner >> bit & 1 == 1 { 1.2 } else { 0.8 };
        let config = PlantConfig {
            inertia_scale: scale(0),
            gravity_scale: scale(1),
            torque_gain: scale(2),
            ..arm()
        };
        stands(&config, Setup::best(), &format_args!("corner {corner:03b}"));
    }
}

#[test]
fn motors_with_another_zero_or_a_dead_zone_stand() {
    for pwm_offset_counts in [-15.0, 15.0] {
        let config = PlantConfig {
            pwm_offset_counts,
            ..arm()
        };
        stands(&config, Setup::best(), &pwm_offset_counts);
    }
    let dead = PlantConfig {
        friction_on: false,
        dead_zone_counts: [PlantConfig::PAPER_DEAD_ZONE_COUNTS; JOINTS],
        ..arm()
    };
    stands(&dead, Setup::best(), &"dead zone");
}

/// Everything up to 40 % off and each joint another, but the board knows what identification
/// can find: the arm's parameters and its servos' calibration.
#[test]
fn arms_drawn_at_random_stand_if_they_are_known() {
    let single = |number: f64| number as f32;
    let joint = |joint: Joint<f64>| Joint {
        zero_count: single(joint.zero_count),
        rad_per_count: single(joint.rad_per_count),
        direction: joint.direction,
        gain_counts_per_nm: single(joint.gain_counts_per_nm),
        offset_counts: single(joint.offset_counts),
    };
    let (mut settled_s, mut off_mrad) = ([f64::INFINITY, 0.0_f64], 0.0_f64);
    for seed in 1..=20 {
        let config = PlantConfig {
            initial: arm().initial,
            ..PlantConfig::drawn(seed, 0.4)
        };
        let setup = Setup {
            arm: config.arm.map(single),
            joints: config.joints.map(joint),
            ..Setup::best()
        };
        for outcome in outcomes(&trial(&config, setup, "upright", 6.0), seed..=seed) {
            within(1.2, outcome.settling_time_s, &outcome);
            at_most(1.0, outcome.mean_error_mrad, &outcome);
            at_most(1.5, outcome.rms_error_mrad, &outcome);
            if let Some(time_s) = outcome.settling_time_s {
                settled_s = [settled_s[0].min(time_s), settled_s[1].max(time_s)];
            }
            let most = outcome
                .mean_error_mrad
                .into_iter()
                .map(f64::abs)
                .fold(0.0, f64::max);
            off_mrad = off_mrad.max(most);
        }
    }
    let [first, last] = settled_s;
    println!("20 arms settled in {first:.2} to {last:.2} s, mean error {off_mrad:.2} mrad at most");
}

#[test]
fn slower_loops_stand() {
    for period_us in [2_000, 5_000, 10_000] {
        let setup = Setup {
            period_us,
            ..Setup::best()
        };
        stands(&arm(), setup, &period_us);
    }
}

/// No fault, and no error at rest to speak of.
fn stands(config: &PlantConfig, setup: Setup, case: &impl Debug) {
    for outcome in outcomes(&trial(config, setup, "upright", 8.0), 1..=4) {
        at_most(2.5, outcome.mean_error_mrad, &(case, &outcome));
    }
}

#[test]
fn tracks_within_two_milliradians() {
    for outcome in outcomes(
        &trial(&arm(), computed_torque(20.0), "min-jerk:0.3,0.3,1", 6.0),
        1..=20,
    ) {
        at_most(2.0, outcome.tracking_rms_mrad.unwrap(), &outcome);
    }
    for outcome in outcomes(
        &trial(&arm(), computed_torque(20.0), "sine:0.3,0.3,1", 9.0),
        1..=20,
    ) {
        at_most(3.0, outcome.tracking_rms_mrad.unwrap(), &outcome);
    }
}

/// 0.2 N m for 50 ms does not even move the arm out of the band in which it
/// counts as settled; three times as much does.
#[test]
fn comes_back_from_a_push() {
    for (joint, torque_nm) in [(0, 0.2), (0, -0.2), (1, 0.2), (1, -0.2), (0, 0.6), (1, 0.6)] {
        let mut pushed = trial(&arm(), Setup::best(), "upright", 5.0);
        pushed.pushes.push(Push {
            joint,
            torque_nm,
            start_ns: 3_000_000_000,
            duration_ns: 50_000_000,
        });
        for outcome in outcomes(&pushed, 1..=10) {
            within(0.6, outcome.recovery_time_s, &outcome);
            let moved_mrad = outcome.displaced_mrad.unwrap()[joint];
            assert!((moved_mrad > 15.0) == (torque_nm > 0.5), "{outcome:?}");
        }
    }
}

/// One reply in five damaged: the estimator predicts through them.
#[test]
fn stands_on_a_fifth_less_samples() {
    let lossy = Trial {
        loss: 0.2,
        ..trial(&arm(), Setup::best(), "upright", 8.0)
    };
    for outcome in outcomes(&lossy, 1..=20) {
        // Two joints, 8 s at 1 kHz.
        let share = outcome.missing_samples as f64 / 16_000.0;
        assert!((share - 0.2).abs() < 0.02, "{share}");
        within(1.2, outcome.settling_time_s, &outcome);
        at_most(1.0, outcome.mean_error_mrad, &outcome);
        at_most(5.0, outcome.peak_to_peak_mrad, &outcome);
    }
}

/// The paper's period, its gain and its push, encoders that only round: beside
/// the best of the reference simulations with a period of delay, an extended
/// Kalman filter with disturbance states that rests 5.60 mrad off, and computed
/// torque on it, 2.42 mrad rms without dry friction and 9.07 with it.
/// As in the reference nothing moves the arm but its controller: encoders are not proved.
#[test]
fn at_45_ms_no_worse_than_the_best_reference() {
    let filter = Tuning {
        // Samples 45 ms apart want a calmer filter, and friction left to its
        // disturbance: a period is as long as friction takes to stop the arm.
        acceleration: 0.3,
        disturbance: 0.1,
        coulomb_nm: 0.0,
        ..Tuning::standing()
    };
    let standing = Setup {
        period_us: 45_000,
        controller: Controller::StateFeedback(Gains::Paper),
        estimator: Config::Kalman(filter),
        // Static friction, not sliding friction: the arm moves by whole periods.
        friction_nm: [0.06; JOINTS],
        ..Setup::best()
    };
    let undisturbed = |mut trial: Trial| {
        trial.script.limits.quiet_ms = 0;
        trial
    };
    // Where friction catches the arm is a matter of where it came from: the paper's
    // 0.49 rad, and starts around it.
    for hundredth in 42..=56 {
        let config = PlantConfig {
            noise_lsb_rms: 0.0,
            ..plant([0.01 * f64::from(hundredth), 0.0], true)
        };
        for outcome in outcomes(
            &undisturbed(trial(&config, standing, "upright", 8.0)),
            1..=1,
        ) {
            at_most(5.60, outcome.mean_error_mrad, &outcome);
        }
    }

    for (friction_on, nm, limit) in [(false, 0.0, 2.42), (true, 0.04, 9.07)] {
        let config = PlantConfig {
            noise_lsb_rms: 0.0,
            ..plant([0.0, 0.0], friction_on)
        };
        let mut tracking = standing;
        tracking.controller = Controller::ComputedTorque {
            natural_rad_s: [17.0; JOINTS],
            damping: [1.0; JOINTS],
        };
        tracking.estimator = Config::Kalman(Tuning {
            coulomb_nm: nm,
            ..filter
        });
        tracking.friction_nm = [nm; JOINTS];
        let trial = undisturbed(trial(&config, tracking, "sine:0.4,0.5,0.3", 14.0));
        for outcome in outcomes(&trial, 1..=3) {
            at_most(limit, outcome.tracking_rms_mrad.unwrap(), &outcome);
        }
    }
}
