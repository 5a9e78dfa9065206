//! The arm thrown and pushed against its limits.

use super::Fixture;
use super::plant::Plant;
use crate::tick::limits::MOTION;
use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Mounting, Parameters, Posture, State};
use armbridge_control::estimate::Config;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::mode::Guards;
use nalgebra::Vector2;

/// Torque at full PWM by equation (5), in the weaker direction.
const FULL_NM: f32 = 1.18;

/// Where the default limits cut, and where the arm is to stop.
const LIMIT_RAD: f64 = 1.5;
const STOP_RAD: f64 = 1.4;

fn fixture(period_us: u32) -> Fixture {
    let limits = Limits {
        torque_nm: [FULL_NM; 2],
        ..Limits::default()
    };
    Fixture::new(limits, period_us)
}

/// Outcome for a joint that was thrown with its motor pushing on.
struct Course {
    farthest_rad: f64,
    end: Plant,
    /// Largest change of its torque within a tick of the last half second.
    ripple_nm: f32,
}

/// Three seconds of it. The fixture is made to forget that it has been braking for
/// long: it would have switched the motors off.
fn thrown(joint: usize, angle: f64, speed: f64, push_nm: f32, period_us: u32) -> Course {
    pushed_on(Plant::new(joint, angle, speed), joint, push_nm, period_us)
}

fn pushed_on(plant: Plant, joint: usize, push_nm: f32, period_us: u32) -> Course {
    let mut fixture = fixture(period_us);
    let believed = plant.believed();
    let mut course = Course {
        farthest_rad: plant.state.q[joint],
        end: plant,
        ripple_nm: 0.0,
    };
    let mut before = Vector2::zeros();
    for tick in 0..3_000_000 / period_us {
        let plant = &mut course.end;
        let mut wanted = Vector2::zeros();
        wanted[joint] = push_nm;
        wanted[1 - joint] = plant.hold(1 - joint) as f32;
        fixture.restart();
        let shaped = fixture
            .limit(&believed, &plant.seen(), wanted, before)
            .unwrap();
        if tick * period_us > 2_500_000 {
            let change = (shaped.torque_nm[joint] - before[joint]).abs();
            course.ripple_nm = course.ripple_nm.max(change);
        }
        before = shaped.torque_nm;
        plant.step(before.cast(), period_us);
        course.farthest_rad = course.farthest_rad.max(plant.state.q[joint]);
    }
    course
}

/// The farthest that a joint gets with full torque against it from the start:
/// nothing can stop it before.
fn farthest_possible(joint: usize, angle: f64, speed: f64) -> f64 {
    let mut plant = Plant::new(joint, angle, speed);
    while plant.state.dq[joint] > 0.0 {
        let mut torque = Vector2::repeat(-f64::from(FULL_NM));
        torque[1 - joint] = plant.hold(1 - joint);
        plant.step(torque, 1_000);
    }
    plant.state.q[joint]
}

#[test]
fn a_joint_that_can_be_stopped_inside_is_and_rests_there() {
    let (mut stopped, mut hopeless, mut held) = (0, 0, 0);
    for joint in 0..2 {
        for angle in [-1.2, -0.5, 0.0, 0.5, 0.9, 1.2, 1.35] {
            for speed in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0] {
                let possible = farthest_possible(joint, angle, speed);
                for push in [0.0, 0.5, FULL_NM] {
                    let case = (joint, angle, speed, push);
                    let course = thrown(joint, angle, speed, push, 1_000);
                    let farthest = course.farthest_rad;
                    if possible < LIMIT_RAD {
                        assert!(farthest < LIMIT_RAD, "{case:?}: {farthest}");
                        stopped += 1;
                    } else {
                        // No way is lost that full torque could have saved.
                        assert!(farthest < possible + 2e-3, "{case:?}: {farthest}");
                        hopeless += 1;
                    }
                    // The few that gravity and motor leave in between swing on.
                    let [q, dq] = [course.end.state.q[joint], course.end.state.dq[joint]];
                    assert!(q.abs() < STOP_RAD + 1e-3, "{case:?}: at {q}");
                    if q.abs() > STOP_RAD - 1e-3 {
                        assert!(dq.abs() < 0.02, "{case:?}: still {dq}");
                        assert!(course.ripple_nm < 1e-3, "{case:?}: {}", course.ripple_nm);
                        held += 1;
                    }
                }
            }
        }
    }
    // 294 in all.
    assert!(
        stopped > 240 && hopeless > 15 && held > 250,
        "{stopped} {hopeless} {held}"
    );
}

#[test]
fn an_arm_that_hangs_is_stopped_as_well() {
    for joint in 0..2 {
        for (angle, speed) in [(-1.2, 3.0), (0.0, 0.0), (0.0, 4.0), (0.9, 2.0)] {
            let plant = || Plant::new(joint, angle, speed).mounted(Mounting::Hanging);
            let course = pushed_on(plant(), joint, FULL_NM, 1_000);
            let (case, farthest) = ((joint, angle, speed), course.farthest_rad);
            assert!((farthest - STOP_RAD).abs() < 1e-3, "{case:?}: {farthest}");
            assert!(course.ripple_nm < 1e-3, "{case:?}: {}", course.ripple_nm);
            // Let go, it comes back by itself.
            let end = pushed_on(plant(), joint, 0.0, 1_000).end;
            assert!(end.state.q[joint].abs() < 0.1, "{case:?}: {end:?}");
        }
    }
}

#[test]
fn ticks_of_any_length_stop_it() {
    for period_us in [600, 5_000, 20_000, 45_000, 100_000] {
        for (angle, speed, push) in [(1.2, 0.0, FULL_NM), (0.0, 4.0, 0.5), (0.9, 2.0, 0.8)] {
            for joint in 0..2 {
                let case = (period_us, joint, angle, speed, push);
                let course = thrown(joint, angle, speed, push, period_us);
                let farthest = course.farthest_rad;
                assert!((farthest - STOP_RAD).abs() < 1e-3, "{case:?}: {farthest}");
                assert!(course.ripple_nm < 1e-3, "{case:?}: {}", course.ripple_nm);
            }
        }
    }
}

/// As a board does it: rounded samples with noise, estimated speeds, torques that
/// act a tick later.
#[test]
fn estimates_are_good_enough_for_it() {
    /// In counts, 1 rms.
    const NOISE: [f32; 8] = [0.0, 1.0, -1.0, 1.5, 0.0, -1.5, -1.0, 1.0];
    let (arm, servo) = (Parameters::<f32>::paper(), Joint::<f32>::paper());
    for config in [Config::standing(), Config::kalman()] {
        for (joint, push) in [(0, 0.5), (1, 0.5), (0, FULL_NM), (1, FULL_NM)] {
            let mut fixture = fixture(1_000);
            let estimator = config.build(&arm, 1e-3).unwrap();
            let mut estimate = estimator.at_rest(Vector2::zeros());
            let mut plant = Plant::new(joint, 0.0, 0.0);
            let mut in_force = Vector2::zeros();
            let (mut farthest, mut ripple) = (0.0_f64, 0.0_f32);
            for tick in 0..3_000_u32 {
                let noise = NOISE[(tick.wrapping_mul(2_654_435_761) >> 29) as usize];
                let sample = |q| servo.angle((servo.position(q) + noise + 0.5) as u16);
                let [a, b] = plant.seen().q.map(sample).into();
                estimator.correct(&mut estimate, [Some(a), Some(b)]);
                let ahead = estimator.advance(&arm, &mut estimate, in_force);
                let mut wanted = Vector2::repeat(push);
                wanted[1 - joint] = plant.hold(1 - joint) as f32;
                fixture.restart();
                let shaped = fixture.limit(&arm, &ahead, wanted, in_force).unwrap();
                plant.step(in_force.cast(), 1_000);
                if tick > 2_000 {
                    ripple = ripple.max((shaped.torque_nm - in_force)[joint].abs());
                }
                in_force = shaped.torque_nm;
                farthest = farthest.max(plant.state.q[joint]);
            }
            let case = (joint, push, farthest, ripple);
            assert!((1.39..1.41).contains(&farthest), "{case:?}");
            // What the noise of the speed makes of it: 30 PWM counts of a thousand.
            assert!(ripple < 0.036, "{case:?}");
        }
    }
}

#[test]
fn what_a_motion_may_ask_is_not_braked() {
    let arm = Parameters::<f32>::paper();
    for period_us in [600, 1_000, 20_000] {
        let mut fixture = fixture(period_us);
        for step in -12..=12_i16 {
            for other in [-1.2, 0.0, 1.2] {
                // Braked as late as that allows, or already there.
                let q = f32::from(step) * 0.1;
                let left = MOTION.angle_rad - q;
                let fastest = (2.0 * MOTION.acceleration_rad_s2 * left).max(0.0).sqrt();
                let state = State {
                    q: Vector2::new(q, other),
                    dq: Vector2::new(fastest.min(MOTION.speed_rad_s), 0.0),
                };
                let brake = Vector2::new(-MOTION.acceleration_rad_s2, 0.0);
                let wanted = Posture::of(state.q).inverse_dynamics(&arm, state.dq, brake);
                let shaped = fixture.limit(&arm, &state, wanted, wanted).unwrap();
                assert!(!shaped.guards.contains(Guards::BRAKED), "{state:?}");
            }
        }
    }
}

#[test]
fn a_joint_that_has_to_be_held_for_long_is_a_violation() {
    let mut fixture = fixture(1_000);
    let arm = Parameters::paper();
    let state = State::at_rest(Vector2::new(0.0, 1.4));
    let wanted = Vector2::new(0.0, 0.2);
    for _ in 1..500 {
        let shaped = fixture.limit(&arm, &state, wanted, wanted).unwrap();
        assert_eq!(shaped.guards, Guards::BRAKED);
    }
    let violation = fixture.limit(&arm, &state, wanted, wanted).unwrap_err();
    assert_eq!(
        (violation.fault, violation.joint),
        (Fault::AngleLimit, Some(1))
    );
}
