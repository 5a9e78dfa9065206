//! Power of the float, and its transitions.

use super::*;
extern crate std;
use std::vec::Vec;

/// Work of the float on the arm in J, beyond gravity as it was weighed, tick by tick, as a hand moves
/// both joints through sines, without rest; and the work of friction compensation that it may do.
fn works(dry_nm: f64, viscous: [f64; 2], phase: f64) -> Vec<(f64, f64)> {
    let [b1, b2] = viscous;
    let arm = Parameters::<f64> {
        b1,
        b2,
        ..Parameters::paper()
    };
    let float = Float::new(&arm, [dry_nm; 2], 1e-3);
    let angle = |t: f64, rad_s: f64| 0.8 * (rad_s * t + phase).sin();
    let at = |tick: i32| {
        let t = f64::from(tick) * 1e-3;
        Vector2::new(angle(t, 2.0 + 0.1 * phase), angle(t, 3.1 - 0.2 * phase))
    };
    let mut memory = float.begin(&arm, &State::at_rest(at(0)), None);
    // Weighed before the motion begins.
    for _ in 0..2_000 {
        float.torque(&mut memory, &arm, &State::at_rest(at(0)));
    }
    let (mut work, mut allowed) = (0.0, 0.0);
    let ticks = 1..20_000;
    let works = ticks.map(|tick| {
        let (before, q) = (at(tick - 1), at(tick));
        let state = State {
            q: before,
            dq: Vector2::zeros(),
        };
        let torque = float.torque(&mut memory, &arm, &state).torque_nm;
        let way = q - before;
        let [a, b] = &memory.joints;
        let gravity_nm = arm
            .gravity(before)
            .component_mul(&Vector2::new(1.0 + a.scale, 1.0 + b.scale));
        work += (torque - gravity_nm).dot(&way);
        let friction = |joint: usize| {
            let speed = way[joint].abs() * 1e3;
            FRICTION_SHARE * (dry_nm + viscous[joint] * speed) * way[joint].abs()
        };
        allowed += friction(0) + friction(1);
        (work, allowed)
    });
    works.collect()
}

/// In motion, the float takes power from the hand. It gives back what its springs have stored, and
/// what the trim has grown to against the motion before: within 0.2 s, by at most 0.02 N m.
#[test]
fn without_friction_in_the_model_no_motion_gets_power() {
    let arm = Parameters::<f64>::paper();
    let springs = arm.weight_nm().map(|nm| nm * LIGHT_SHARE * REACH_RAD);
    let stored_j = springs.iter().sum::<f64>() + 2.0 * CATCH_NM_S * 0.2;
    for phase in 0..20 {
        let works = works(0.0, [0.0; 2], f64::from(phase) * 0.3);
        // What a hand held against at the start has faded.
        for pair in works[4_000..].windows(200) {
            let given_j = pair[199].0 - pair[0].0;
            assert!(given_j < stored_j, "phase {phase}: {given_j} J");
        }
        let taken_j = -works[works.len() - 1].0;
        assert!(taken_j > 0.5, "phase {phase}: {taken_j} J in 20 s");
    }
}

/// With it, no more than the compensated share of the model's friction takes.
#[test]
fn friction_is_compensated_in_part() {
    let arm = Parameters::<f64>::paper();
    for phase in 0..20 {
        let works = works(0.04, [arm.b1, arm.b2], f64::from(phase) * 0.3);
        for (work, allowed) in works {
            assert!(
                work < allowed + 1e-3,
                "phase {phase}: {work} J of {allowed} J"
            );
        }
    }
}

/// Held by another torque than the model's, it begins with that one.
#[test]
fn it_begins_from_the_torque_in_force() {
    let arm = Parameters::<f64>::paper();
    let float = Float::new(&arm, [0.04; 2], 1e-3);
    let state = State::at_rest(Vector2::new(0.4, -0.5));
    let held_nm = arm.gravity(state.q) + Vector2::new(0.1, -0.04);
    let mut memory = float.begin(&arm, &state, Some(held_nm));
    for _ in 0..1_000 {
        let torque_nm = float.torque(&mut memory, &arm, &state).torque_nm;
        assert!((torque_nm - held_nm).amax() < 1e-9);
    }
}

/// What a hand holds against it at rest is taken over without a step.
#[test]
fn a_load_is_taken_over_without_a_step() {
    let arm = Parameters::<f64>::paper();
    let float = Float::new(&arm, [0.04; 2], 1e-3);
    let leaning = State::at_rest(Vector2::new(0.4, -0.5));
    let mut memory = float.begin(&arm, &leaning, None);
    let away = State::at_rest(leaning.q + Vector2::new(0.02, -0.02));
    let torques: Vec<_> = (0..3_000)
        .map(|_| float.torque(&mut memory, &arm, &away).torque_nm)
        .collect();
    for two in torques[100..].windows(2) {
        // A quarter of a PWM count.
        assert!((two[1] - two[0]).amax() < 3e-4, "{two:?}");
    }
    let joints = memory.joints;
    assert!(joints.iter().all(|joint| joint.is_weighed), "{joints:?}");
}
