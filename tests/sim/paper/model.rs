//! Equations (1) to (4), (6) and (7).

use armbridge_control::arm::{Discrete, Linear, Parameters, State};
use nalgebra::{Matrix4, SMatrix, Vector2};

use super::reference::{at, discrete, distance, list, matrix, number, vector};

fn upright<T: armbridge_control::real::Real>(arm: &Parameters<T>) -> Linear<T> {
    arm.linearise(Vector2::zeros())
}

fn arms() -> [(&'static str, Parameters<f64>); 2] {
    [
        ("table1 no M1", Parameters::table_1().with_mass_as_printed()),
        ("fitted", Parameters::paper()),
    ]
}

#[test]
fn table_1_is_as_printed() {
    let table = at(&["params_table1"]);
    let arm = Parameters::<f64>::table_1();
    let fields = [
        ("L1", arm.l1),
        ("L2", arm.l2),
        ("M1", arm.m1),
        ("M2", arm.m2),
        ("g", arm.g),
        ("I1x", arm.i1x),
        ("I1y", arm.i1y),
        ("I1z", arm.i1z),
        ("I2x", arm.i2x),
        ("I2y", arm.i2y),
        ("I2z", arm.i2z),
        ("b1", arm.b1),
        ("b2", arm.b2),
    ];
    for (name, value) in fields {
        assert_eq!(value, number(&table[name]), "{name}");
    }
}

#[test]
fn all_24_model_vectors_to_1e_12() {
    const TOLERANCE: f64 = 1e-12;
    let [(_, printed), _] = arms();
    let whole = Parameters::<f64>::table_1();
    let vectors = list(at(&["model_test_vectors", "vectors"]));
    assert_eq!(vectors.len(), 24);
    for (number, v) in vectors.iter().enumerate() {
        let state = State {
            q: vector(&v["q"]),
            dq: vector(&v["qd"]),
        };
        let (q, torque) = (state.q, vector(&v["tau"]));
        let coriolis = whole.coriolis(q, state.dq);
        let worst = [
            distance(&printed.mass(q), &matrix(&v["M_paper"])),
            distance(&whole.mass(q), &matrix(&v["M_with_M1term"])),
            distance(&whole.gravity(q), &vector(&v["G"])),
            distance(&coriolis, &matrix(&v["C_christoffel"])),
            distance(&(coriolis * state.dq), &vector(&v["coriolis_vec"])),
            distance(
                &printed.acceleration(&state, torque),
                &vector(&v["qdd_exactC_noM1"]),
            ),
            distance(
                &whole.acceleration(&state, torque),
                &vector(&v["qdd_exactC_M1"]),
            ),
        ]
        .into_iter()
        .fold(0.0, f64::max);
        assert!(worst < TOLERANCE, "vector {number}: {worst:e}");
    }
}

#[test]
fn f32_agrees_with_f64_on_the_model_vectors() {
    let arm_32 = Parameters::<f32>::paper();
    let arm_64 = Parameters::<f64>::paper();
    for v in list(at(&["model_test_vectors", "vectors"])) {
        let state = State {
            q: vector(&v["q"]),
            dq: vector(&v["qd"]),
        };
        let torque: Vector2<f64> = vector(&v["tau"]);
        let exact = arm_64.acceleration(&state, torque);
        let single = State {
            q: state.q.cast::<f32>(),
            dq: state.dq.cast(),
        };
        let close = arm_32.acceleration(&single, torque.cast()).cast::<f64>();
        // Sixteen roundings of the largest term.
        let scale = 10.0 + exact.amax();
        assert!(distance(&close, &exact) < scale * 16.0 * f64::from(f32::EPSILON));
    }
}

/// Classical Runge-Kutta, written apart from the plant's.
fn runge_kutta(arm: &Parameters<f64>, state: State<f64>, step_s: f64) -> State<f64> {
    let slope = |x: State<f64>| {
        let acceleration = arm.acceleration(&x, Vector2::zeros());
        State {
            q: x.dq,
            dq: acceleration,
        }
        .to_vector()
    };
    let x = state.to_vector();
    let at = |x| slope(State::from_vector(x));
    let k1 = at(x);
    let k2 = at(x + k1 * (step_s / 2.0));
    let k3 = at(x + k2 * (step_s / 2.0));
    let k4 = at(x + k3 * step_s);
    State::from_vector(x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (step_s / 6.0))
}

#[test]
fn energy_is_conserved_without_friction() {
    let test = at(&["energy_test"]);
    let expected = &test["results"]["exact C, no M1 term"];
    let arm = Parameters {
        b1: 0.0,
        b2: 0.0,
        ..Parameters::table_1().with_mass_as_printed()
    };
    let step_s = number(&test["h"]);
    let steps = (number(&test["T"]) / step_s).round() as u32;
    let mut state = State::from_vector(vector(&test["x0"]));
    let start = arm.energy(&state);
    assert!((start - number(&expected["E0"])).abs() < 1e-15);
    let mut drift: f64 = 0.0;
    for _ in 0..steps {
        state = runge_kutta(&arm, state, step_s);
        drift = drift.max((arm.energy(&state) - start).abs());
    }
    assert!(drift < 1e-9, "{drift:e} J");
    let end = vector(&expected["x_end"]);
    assert!(distance(&state.to_vector(), &end) < 1e-8);
}

#[test]
fn mass_derivative_minus_twice_coriolis_is_skew() {
    let arm = Parameters::<f64>::paper();
    for v in list(at(&["model_test_vectors", "vectors"])) {
        let (q, dq): (Vector2<f64>, Vector2<f64>) = (vector(&v["q"]), vector(&v["qd"]));
        let h = 1e-6;
        let slope = (arm.mass(q + dq * h) - arm.mass(q - dq * h)) / (2.0 * h);
        let skew = slope - arm.coriolis(q, dq) * 2.0;
        assert!((skew + skew.transpose()).amax() < 1e-9);
    }
}

#[test]
fn equation_7_comes_out_to_all_printed_digits() {
    let printed = Discrete::paper();
    assert_eq!(printed.a, matrix::<4, 4>(at(&["linear", "A7"])));
    assert_eq!(printed.b, matrix::<4, 2>(at(&["linear", "B7"])));
    let model = upright(&Parameters::paper()).euler(0.045);
    let rounded = |x: f64| (x * 1e4).round() / 1e4;
    assert_eq!(model.a.map(rounded), printed.a);
    assert_eq!(model.b.map(rounded), printed.b);
    // The literal Table 1 does not give it.
    let literal = upright(&Parameters::table_1().with_mass_as_printed()).euler(0.045);
    assert!(distance(&literal.a, &printed.a) > 4e-3);
}

#[test]
fn continuous_models_agree() {
    for (name, suffix) in [("table1 no M1", "table1"), ("fitted", "fitted")] {
        let (_, arm) = arms().into_iter().find(|(arm, _)| *arm == name).unwrap();
        let linear = upright(&arm);
        let a = matrix(at(&["linear", &format!("Ac_{suffix}")]));
        let b = matrix(at(&["linear", &format!("Bc_{suffix}")]));
        assert!(distance(&linear.a, &a) < 1e-13, "{name}");
        assert!(distance(&linear.b, &b) < 1e-13, "{name}");
    }
}

#[test]
fn linearisation_is_the_derivative_at_any_setpoint() {
    let arm = Parameters::<f64>::paper();
    for q_ref in [[0.0, 0.0], [0.5, -0.4], [-0.3, 1.2], [3.0, 2.0]].map(Vector2::from) {
        let linear = arm.linearise(q_ref);
        let torque = arm.gravity(q_ref);
        let at_rest = State::at_rest(q_ref).to_vector();
        assert!(arm.acceleration(&State::at_rest(q_ref), torque).amax() < 1e-12);
        let h = 1e-6;
        for column in 0..4 {
            let mut offset = nalgebra::Vector4::zeros();
            offset[column] = h;
            let above = arm.acceleration(&State::from_vector(at_rest + offset), torque);
            let below = arm.acceleration(&State::from_vector(at_rest - offset), torque);
            let slope = (above - below) / (2.0 * h);
            let analytic = linear.a.fixed_view::<2, 1>(2, column).into_owned();
            assert!(distance(&slope, &analytic) < 1e-7, "{q_ref} {column}");
        }
    }
}

#[test]
fn euler_and_zero_order_hold_agree_at_every_period() {
    // f64: a few roundings of entries of order one. f32: likewise.
    const DOUBLE: f64 = 2e-15;
    const SINGLE: f64 = 4.0 * f32::EPSILON as f64;
    let mut compared = 0;
    for (name, arm) in arms() {
        for period_ms in [45.0, 20.0, 10.0, 5.0, 2.0, 1.0] {
            let period_s = period_ms / 1000.0;
            let expected = at(&["discretisations", &format!("{name} T={period_s}")]);
            let linear = upright(&arm);
            for (kind, model) in [
                ("euler_", linear.euler(period_s)),
                ("zoh_", linear.zero_order_hold(period_s)),
            ] {
                let expected = discrete(expected, kind);
                let context = format!("{name} {kind} {period_ms} ms");
                assert!(distance(&model.a, &expected.a) < DOUBLE, "{context} A");
                assert!(distance(&model.b, &expected.b) < DOUBLE, "{context} B");
                compared += 1;
            }
            if name == "fitted" {
                let expected = discrete(expected, "zoh_");
                let single = upright(&Parameters::<f32>::paper()).zero_order_hold(period_s as f32);
                assert!(distance(&single.a.cast(), &expected.a) < SINGLE);
                assert!(distance(&single.b.cast(), &expected.b) < SINGLE);
            }
        }
    }
    assert_eq!(compared, 24);
}

#[test]
fn zero_order_hold_composes_from_microseconds_to_seconds() {
    let linear = upright(&Parameters::<f64>::paper());
    for period_s in [1e-6, 5e-4, 0.045, 0.3, 2.0] {
        let once = linear.zero_order_hold(period_s);
        let twice = linear.zero_order_hold(2.0 * period_s);
        let scale = twice.a.amax();
        assert!(distance(&(once.a * once.a), &twice.a) < 1e-13 * scale);
        let b: SMatrix<f64, 4, 2> = once.a * once.b + once.b;
        assert!(distance(&b, &twice.b) < 1e-13 * scale);
    }
    // A short period in f32 keeps its digits: B itself, not B lost in I.
    let exact = linear.zero_order_hold(5e-4);
    let single = upright(&Parameters::<f32>::paper()).zero_order_hold(5e-4);
    let relative = (single.b.m11 as f64 / exact.b.m11 - 1.0).abs();
    assert!(relative < 1e-6, "{relative:e}");
    // And a model that is not finite ends, not hangs.
    let broken = Linear {
        a: Matrix4::from_element(f64::NAN),
        ..linear
    };
    assert!(broken.zero_order_hold(0.001).a.m11.is_nan());
}
