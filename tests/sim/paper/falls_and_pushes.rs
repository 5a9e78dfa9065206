//! The paper's two experiments on joint 1, section 3, as the bench's arm does them:
//! times, speeds, where it ends, and what that depends on.

use core::f64::consts::{FRAC_PI_2, PI};

use armbridge_control::arm::{Parameters, State};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Body, Friction};
use nalgebra::Vector2;
use serde_json::Value;

use super::reference::{at, list, number};

/// The reference looked at the arm every 10 ms.
const LOOK_NS: u64 = 10_000_000;
const LOOK_S: f64 = 0.01;
/// The paper's constant input in N m, and where it begins in rad.
const PUSH_NM: f64 = -0.3924;
const PUSH_FROM_RAD: f64 = 0.49;

fn with_b1(b1: f64) -> Parameters<f64> {
    Parameters {
        b1,
        ..Parameters::paper()
    }
}

/// Joint 1 from rest, every 10 ms for so many s.
fn run(
    arm: Parameters<f64>,
    friction: Friction,
    from_rad: f64,
    torque_nm: f64,
    duration_s: f64,
) -> Vec<State<f64>> {
    let initial = State::at_rest(Vector2::new(from_rad, 0.0));
    let mut body = Body::new(arm, [friction; JOINTS], [[-9.0, 9.0]; JOINTS], initial);
    body.set_torque(0, Vector2::new(torque_nm, 0.0));
    let looks = (duration_s / LOOK_S).round() as u64;
    let look = |k: u64| {
        body.advance(k * LOOK_NS);
        body.state(k * LOOK_NS)
    };
    (0..=looks).map(look).collect()
}

/// When it is first looked at beyond an angle, going away from upright or towards it.
fn passes_s(run: &[State<f64>], is_beyond: impl Fn(f64) -> bool) -> f64 {
    let first = run.iter().position(|state| is_beyond(state.q.x));
    first.expect("it passes") as f64 * LOOK_S
}

fn fastest(run: &[State<f64>]) -> f64 {
    run.iter().map(|state| state.dq.x.abs()).fold(0.0, f64::max)
}

fn near(what: &str, found: f64, reference: &Value, tolerance: f64) {
    let expected = number(reference);
    let error = (found - expected).abs();
    assert!(error <= tolerance, "{what}: {found}, not {expected}");
}

#[test]
fn a_constant_input_moves_the_arm_as_computed() {
    for (name, b1) in [("0.24", 0.24), ("0.239", 0.239), ("0.421", 0.421)] {
        let name = format!("const_input b={name}");
        let reference = at(&["identification", &name]);
        let run = run(with_b1(b1), Friction::NONE, PUSH_FROM_RAD, PUSH_NM, 8.0);
        for (key, k) in [("q_0p5", 50), ("q_1", 100), ("q_2", 200)] {
            near(&name, run[k].q.x, &reference[key], 1e-6);
        }
        let upright_s = passes_s(&run, |q| q < 0.0);
        near("upright", upright_s, &reference["t_zero"], 1e-9);
        let level_s = passes_s(&run, |q| q < -FRAC_PI_2);
        near("level", level_s, &reference["t_mpi2"], 1e-9);
        near("speed", fastest(&run), &reference["peak_speed"], 1e-6);
        let last = run.last().expect("looks").q.x;
        near("end", last, &reference["final"], 1e-4);
    }
    let q = |b1| {
        run(with_b1(b1), Friction::NONE, PUSH_FROM_RAD, PUSH_NM, 2.0)[200]
            .q
            .x
    };
    let apart_rad = q(0.24) - q(0.239);
    assert!((apart_rad - 0.010).abs() < 5e-4, "{apart_rad}");
}

#[test]
fn a_constant_input_has_the_equilibria_computed() {
    let arm = Parameters::<f64>::paper();
    let reference = at(&["identification", "const_input_equilibria"]);
    let hold = -arm.gravity(Vector2::new(PUSH_FROM_RAD, 0.0)).x;
    near("hold", hold, &reference["hold_torque_at_0p49"], 1e-12);
    let names = [
        ("unstable", true),
        ("stable_same_side", false),
        ("stable_other_side", false),
    ];
    for (name, falls) in names {
        let q = Vector2::new(number(&reference[name]), 0.0);
        let rest = State::at_rest(q);
        let ddq = arm.acceleration(&rest, Vector2::new(PUSH_NM, 0.0)).x;
        assert!(ddq.abs() < 1e-6, "{name}: {ddq}");
        assert_eq!(arm.gravity_slope(q).m11 < 0.0, falls, "{name}");
    }
    // It moves up only because it begins below the unstable one.
    assert!(PUSH_FROM_RAD < number(&reference["unstable"]));
}

#[test]
fn a_free_fall_takes_the_times_computed() {
    let names = [
        ("freefall b=0.24 tc=0", 0.24, 0.0),
        ("freefall b=0.421 tc=0", 0.421, 0.0),
        ("freefall b=0.24 tc=0.04", 0.24, 0.04),
        ("freefall b=0.24 tc=0.06", 0.24, 0.06),
        ("freefall b=0.24 tc=0.1", 0.24, 0.1),
    ];
    for (name, b1, coulomb_nm) in names {
        let reference = at(&["identification", name]);
        // All of them start where static friction has let go.
        let friction = Friction {
            coulomb_nm,
            static_nm: coulomb_nm,
            stribeck_rad_s: 0.0,
            load: 0.0,
        };
        let from_rad = number(&reference["q0"]);
        let run = run(with_b1(b1), friction, from_rad, 0.0, 10.0);
        let level_s = passes_s(&run, |q| q > FRAC_PI_2);
        near(name, level_s, &reference["t_half"], 1e-9);
        near(name, fastest(&run), &reference["vmax"], 1e-5);
        let end_deg = run.last().expect("looks").q.x.to_degrees();
        near(name, end_deg, &reference["final_deg"], 0.02);
    }
}

#[test]
fn inertia_matters_little_for_a_fall_and_friction_much() {
    let arm = Parameters::<f64>::paper();
    let level_s = |arm| {
        let states = run(arm, Friction::NONE, 0.1, 0.0, 4.0);
        let k = states.iter().position(|state| state.q.x > FRAC_PI_2);
        let k = k.expect("it falls");
        let [before, after] = [states[k - 1].q.x, states[k].q.x];
        (k as f64 - (after - FRAC_PI_2) / (after - before)) * LOOK_S
    };
    let change = |arm| 100.0 * (level_s(arm) / level_s(with_b1(0.24)) - 1.0);
    for (sign, by_inertia, by_friction) in [(-1.0, -7.2, -28.5), (1.0, 6.6, 33.2)] {
        // The moments of inertia of Table 1, which are three quarters of M(1,1).
        let scale = 1.0 + 0.5 * sign;
        let inert = Parameters {
            i1x: arm.i1x * scale,
            i2x: arm.i2x * scale,
            i2z: arm.i2z * scale,
            ..arm
        };
        let found = change(inert);
        assert!((found - by_inertia).abs() < 0.1, "inertia: {found}");
        let found = change(with_b1(0.24 * scale));
        assert!((found - by_friction).abs() < 0.1, "friction: {found}");
    }
}

#[test]
fn hanging_down_it_swings_with_one_friction_and_creeps_with_the_other() {
    let down = Vector2::new(PI, 0.0);
    let joint = |b1| {
        let a = with_b1(b1).linearise(down).a;
        (-a[(2, 2)] / 2.0, a[(2, 0)])
    };
    let reference = at(&["identification", "poles_at_pi"]);
    let (re, stiffness) = joint(0.24);
    let pole = &reference["b=.24"][0];
    near("real part", -re, &pole["re"], 1e-9);
    let im = (-stiffness - re * re).sqrt();
    near("imaginary part", im, &pole["im"], 1e-9);
    let (re, stiffness) = joint(0.421);
    let root = (re * re + stiffness).sqrt();
    let poles = list(&reference["b=.421"]);
    near("fast", -re - root, &poles[0], 1e-9);
    near("slow", -re + root, &poles[1], 1e-9);
}
