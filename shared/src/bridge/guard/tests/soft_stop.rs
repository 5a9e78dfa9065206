//! The arm thrown and pushed against its limits.

extern crate std;
use super::plant::Plant;
use crate::actuator::Joint;
use crate::arm::{Parameters, Posture, State};
use crate::bridge::guard::Guard;
use crate::bridge::limits::MOTION;
use crate::estimate::Config;
use crate::link::limits::Limits;
use crate::link::mode::{Fault, Guards};
use nalgebra::Vector2;

/// What a servo gives at full PWM by equation (5), the weaker way.
const FULL_NM: f32 = 1.18;

/// Where the default limits cut, and where the arm is to stop.
const LIMIT_RAD: f64 = 1.5;
const STOP_RAD: f64 = 1.4;

fn guard(period_us: u32) -> Guard {
    let limits = Limits {
        torque_nm: [FULL_NM; 2],
        ..Limits::default()
    };
    Guard::new(limits, period_us)
}

/// What became of a joint that was thrown with its motor pushing on.
struct Course {
    farthest_rad: f64,
    end: Plant,
    /// Largest change of its torque within a tick of the last half second.
    ripple_nm: f32,
}

/// Three seconds of it. The guard is made to forget that it has been braking for
/// long: it would have switched the motors off.
fn thrown(joint: usize, angle: f64, speed: f64, push_nm: f32, period_us: u32) -> Course {
    let mut guard = guard(period_us);
    let mut course = Course {
        farthest_rad: angle,
        end: Plant::new(joint, angle, speed),
        ripple_nm: 0.0,
    };
    let mut before = Vector2::zeros();
    for tick in 0..3_000_000 / period_us {
        let plant = &mut course.end;
        let mut wanted = Vector2::zeros();
        wanted[joint] = push_nm;
        wanted[1 - joint] = plant.hold(1 - joint) as f32;
        guard.restart();
        let shaped = guard
            .shape(&Parameters::paper(), &plant.seen(), wanted, before)
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
    let (mut stopped, mut hopeless) = (0, 0);
    for joint in 0..2 {
        for angle in [-1.2, -0.5, 0.0, 0.5, 0.9, 1.2, 1.35] {
            for speed in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0] {
                let possible = farthest_possible(joint, angle, speed);
                for push in [0.1, 0.5, FULL_NM] {
                    let course = thrown(joint, angle, speed, push, 1_000);
                    let case = (joint, angle, speed, push);
                    let farthest = course.farthest_rad;
                    if possible < LIMIT_RAD {
                        assert!(farthest < LIMIT_RAD, "{case:?}: {farthest}");
                        stopped += 1;
                    } else {
                        // No way is left that full torque could have saved.
                        assert!(farthest < possible + 2e-3, "{case:?}: {farthest}");
                        hopeless += 1;
                    }
                    let (q, dq) = (course.end.state.q[joint], course.end.state.dq[joint]);
                    assert!(q < STOP_RAD + 1e-3, "{case:?}: at {q}");
                    assert!(dq.abs() < 1e-3, "{case:?}: still {dq}");
                    assert!(course.ripple_nm < 1e-4, "{case:?}: {}", course.ripple_nm);
                }
            }
        }
    }
    std::println!("{stopped} {hopeless}");
    assert!(stopped > 200 && hopeless > 10, "{stopped} {hopeless}");
}

#[test]
fn slow_ticks_stop_it_too() {
    for period_us in [600, 5_000, 10_000, 20_000, 45_000, 100_000] {
        for (angle, speed, push) in [(1.2, 0.0, FULL_NM), (0.0, 4.0, 0.5), (0.9, 2.0, 0.8)] {
            for joint in 0..2 {
                let course = thrown(joint, angle, speed, push, period_us);
                std::println!(
                    "{period_us} {joint} {angle} {speed} {push}: {} {} {}",
                    course.farthest_rad,
                    course.end.state.q,
                    course.ripple_nm
                );
            }
        }
    }
}

/// As the board does it: rounded samples with a count of noise, an estimated
/// speed, a torque that acts a tick later.
#[test]
fn estimates_do_for_it() {
    let (arm, servo) = (Parameters::<f32>::paper(), Joint::<f32>::paper());
    for (config, push) in [
        (Config::standing(), 0.5),
        (Config::kalman(), 0.5),
        (Config::standing(), 1.0),
        (Config::kalman(), 1.0),
    ] {
        for joint in 0..2 {
            let mut guard = guard(1_000);
            let mut estimator = config.build(&arm, 1e-3).unwrap();
            estimator.reset(Vector2::zeros());
            let mut plant = Plant::new(joint, 0.0, 0.0);
            let mut in_force = Vector2::zeros();
            let (mut farthest, mut ripple, mut ripple_n) = (0.0_f64, 0.0_f32, 0.0_f32);
            for tick in 0..3_000_u32 {
                let measured = plant.seen().q.map(|q| {
                    let noise = [0.0, 1.0, -1.0, 2.0, 0.0, -2.0, -1.0, 1.0]
                        [(tick.wrapping_mul(2_654_435_761) >> 29) as usize];
                    servo.angle((servo.position(q) + 0.5 + noise * 0.8) as u16)
                });
                let [a, b] = measured.into();
                estimator.correct([Some(a), Some(b)]);
                let ahead = estimator.advance(in_force);
                let mut wanted = Vector2::repeat(push);
                wanted[1 - joint] = plant.hold(1 - joint) as f32;
                guard.restart();
                let shaped = guard.shape(&arm, &ahead, wanted, in_force).unwrap();
                plant.step(in_force.cast(), 1_000);
                if tick > 2_000 {
                    ripple = ripple.max((shaped.torque_nm[joint] - in_force[joint]).abs());
                    ripple_n = ripple_n.max(plant.state.dq[joint].abs() as f32);
                }
                in_force = shaped.torque_nm;
                farthest = farthest.max(plant.state.q[joint]);
            }
            std::println!(
                "est {joint} {push}: far {farthest} ripple {ripple} speed {ripple_n} at {}",
                plant.state.q
            );
        }
    }
}
