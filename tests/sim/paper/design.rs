//! Gains: (8), (10), (12), and what they would be elsewhere.

use armbridge_control::arm::{Discrete, Linear, Parameters};
use armbridge_control::controller::{Lqr, Weights};
use armbridge_control::design::placement::{
    Error, Poles, current_gain, prediction_gain, to_current,
};
use armbridge_control::design::riccati;
use nalgebra::{Matrix2, Matrix2x4, Matrix4, Vector2, Vector4};

use super::reference::{at, discrete, distance, matrix, vector};

fn single(model: &Discrete<f64>) -> Discrete<f32> {
    Discrete {
        a: model.a.cast(),
        b: model.b.cast(),
    }
}

fn gain(model: &Discrete<f64>) -> Matrix2x4<f64> {
    Lqr::design(model, &Weights::paper()).unwrap().gain
}

/// Eigenvalues of the closed loop, sorted; all real in these cases.
fn poles(model: &Discrete<f64>, k: &Matrix2x4<f64>) -> Vector4<f64> {
    let mut poles = (model.a - model.b * k).complex_eigenvalues();
    poles.as_mut_slice().sort_by(|x, y| x.re.total_cmp(&y.re));
    assert!(poles.iter().all(|pole| pole.im.abs() < 1e-12));
    poles.map(|pole| pole.re)
}

#[test]
fn riccati_with_7_and_8_gives_the_reference_gain() {
    let reference: Matrix2x4<f64> = matrix(at(&["lqr", "results", "eq7", "K"]));
    let model = Discrete::paper();
    assert!(distance(&gain(&model), &reference) < 1e-10);
    let f32_gain = Lqr::design(&single(&model), &Weights::paper())
        .unwrap()
        .gain;
    assert!(distance(&f32_gain.cast(), &reference) < 1e-4);
    // The cost matrix, whose largest entry is 205.
    let weights = Weights::paper();
    let q = Matrix4::from_diagonal(&Vector4::from(weights.q));
    let r = Matrix2::from_diagonal(&Vector2::from(weights.r));
    let solution = riccati::solve(&model.a, &model.b, &q, &r).unwrap();
    let cost = matrix(at(&["lqr", "results", "eq7", "P"]));
    assert!(distance(&solution.cost, &cost) < 1e-10);
}

#[test]
fn f32_designs_gains_from_a_tenth_of_a_millisecond_to_a_tenth_of_a_second() {
    // The slower pole is at exp(-3.2 T), so what f32 rounds off an entry near 1
    // is the larger a share of its distance from 1 the shorter the period.
    let tolerance = |period_s: f64| 1e-4_f64.max(f64::from(f32::EPSILON) / (3.2 * period_s));
    let linear = Parameters::<f64>::paper().linearise(Vector2::zeros());
    let linear_32 = Parameters::<f32>::paper().linearise(Vector2::zeros());
    for period_s in [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.045, 0.1] {
        let exact = gain(&linear.zero_order_hold(period_s));
        let model = linear_32.zero_order_hold(period_s as f32);
        let close = Lqr::design(&model, &Weights::paper()).unwrap().gain;
        let error = distance(&close.cast(), &exact);
        assert!(error < tolerance(period_s), "{period_s} s: {error:e}");
    }
}

#[test]
fn equation_10_is_that_gain_cut_not_rounded() {
    let optimal = gain(&Discrete::paper());
    let printed = Lqr::<f64>::paper().gain;
    assert_eq!(printed, matrix::<2, 4>(at(&["lqr", "K_printed"])));
    // A hair is added where the optimum is an exact zero.
    assert_eq!(
        optimal.map(|k| ((k + 1e-12) * 100.0).trunc() / 100.0),
        printed
    );
    let rounded = optimal.map(|k| (k * 100.0).round() / 100.0);
    assert_eq!(rounded[(1, 1)], 1.11);
    assert_eq!(rounded[(1, 3)], 0.21);
}

#[test]
fn gains_for_other_models_and_periods() {
    // What the reference solvers agree to among themselves is 1.2e-14.
    let named = [
        ("eq7", "linear", ""),
        ("euler_table1", "table1 no M1 T=0.045", "euler_"),
        ("zoh_table1", "table1 no M1 T=0.045", "zoh_"),
        ("euler_fitted", "fitted T=0.045", "euler_"),
        ("zoh_fitted", "fitted T=0.045", "zoh_"),
    ];
    for (name, group, kind) in named {
        let model = if group == "linear" {
            Discrete::paper()
        } else {
            discrete(at(&["discretisations", group]), kind)
        };
        let expected = matrix(at(&["lqr", "results", name, "K"]));
        assert!(distance(&gain(&model), &expected) < 1e-10, "{name}");
    }

    let linear = Linear {
        a: matrix(at(&["linear", "Ac_from_eq7"])),
        b: matrix(at(&["linear", "Bc_from_eq7"])),
    };
    for period_s in [0.045, 0.02, 0.01, 0.005, 0.002, 0.001] {
        for (kind, model) in [
            ("euler", linear.euler(period_s)),
            ("zoh", linear.zero_order_hold(period_s)),
        ] {
            let name = format!("{kind}_eq7cont_T={period_s}");
            let expected: Matrix2x4<f64> = matrix(at(&["lqr", "results", &name, "K"]));
            assert!(distance(&gain(&model), &expected) < 1e-10, "{name}");
            let close = Lqr::design(&single(&model), &Weights::paper()).unwrap();
            let error = distance(&close.gain.cast(), &expected);
            assert!(error < 1e-4, "{name} in f32: {error:e}");
        }
    }
    // Ever shorter periods lead to the continuous optimum, linearly.
    let limit: Matrix2x4<f64> = matrix(at(&["lqr", "care_eq7cont_K"]));
    let short = gain(&linear.zero_order_hold(1e-4));
    assert!(distance(&short, &limit) < 1e-3);
}

#[test]
fn the_printed_gain_stabilises_model_and_plant() {
    let k = Lqr::paper().gain;
    let linear = Linear {
        a: matrix(at(&["linear", "Ac_from_eq7"])),
        b: matrix(at(&["linear", "Bc_from_eq7"])),
    };
    let on_model = poles(&Discrete::paper(), &k);
    let on_plant = poles(&linear.zero_order_hold(0.045), &k);
    assert!(distance(&on_model, &vector(at(&["lqr", "eig eq7 printedK"]))) < 1e-12);
    let expected = vector(at(&["lqr", "eig zoh_of_eq7 printedK"]));
    assert!(distance(&on_plant, &expected) < 1e-12);
}

/// Both real eigenvalues, larger first.
fn eigenvalues(m: &Matrix2<f64>) -> Vector2<f64> {
    let values = m.complex_eigenvalues();
    assert!(values.iter().all(|value| value.im == 0.0));
    let (x, y) = (values[0].re, values[1].re);
    Vector2::new(x.max(y), x.min(y))
}

fn error_dynamics(a: &Matrix2<f64>, l: Vector2<f64>) -> Matrix2<f64> {
    a - Matrix2::from_columns(&[l, Vector2::zeros()])
}

#[test]
fn the_printed_observer_is_a_slow_one_cut_to_two_decimals() {
    let [a1, a2] = Discrete::<f64>::paper().joints();
    let printed = [Vector2::new(0.29, 0.72), Vector2::new(0.34, 0.34)];
    let expected = [
        at(&["observer", "eig_joint1"]),
        at(&["observer", "eig_joint2"]),
    ];
    for ((a, l), expected) in [a1, a2].iter().zip(printed).zip(expected) {
        let mut expected: Vector2<f64> = vector(expected);
        expected = Vector2::new(expected.max(), expected.min());
        assert!(distance(&eigenvalues(&error_dynamics(a, l)), &expected) < 1e-12);
    }
    let slow = [Poles::Real(0.60, 0.75), Poles::Real(0.65, 0.70)];
    let exact = at(&["observer", "L_for_poles_0.6_0.65_0.7_0.75"]);
    for (joint, (a, poles)) in [a1, a2].iter().zip(slow).enumerate() {
        let l = prediction_gain(a, poles).unwrap();
        let column = matrix::<4, 2>(exact).column(joint).into_owned();
        assert!(distance(&l, &Vector2::new(column[joint], column[joint + 2])) < 1e-12);
        assert_eq!(l.map(|gain| (gain * 100.0).trunc() / 100.0), printed[joint]);
    }
}

#[test]
fn every_pairing_of_the_printed_poles_on_euler_and_exact_models() {
    let linear = Linear {
        a: matrix(at(&["linear", "Ac_from_eq7"])),
        b: matrix(at(&["linear", "Bc_from_eq7"])),
    };
    let cases = [
        ("correct_L_pairings_eq7", Discrete::paper()),
        ("correct_L_pairings_zoh_eq7", linear.zero_order_hold(0.045)),
    ];
    let mut placed = 0;
    for (group, model) in cases {
        for (pairing, expected) in at(&["observer", group]).as_object().unwrap() {
            for (joint, (a, pair)) in model.joints().iter().zip(pairing.split('|')).enumerate() {
                let pair: Vec<f64> = serde_json::from_str(pair).unwrap();
                let poles = Poles::Real(pair[0], pair[1]);
                let l = prediction_gain(a, poles).unwrap();
                let column = |l: &serde_json::Value| {
                    let l = matrix::<4, 2>(l).column(joint).into_owned();
                    Vector2::new(l[joint], l[joint + 2])
                };
                assert!(distance(&l, &column(&expected["L"])) < 1e-12, "{pairing}");
                let back = eigenvalues(&error_dynamics(a, l));
                let wanted = Vector2::new(pair[0].max(pair[1]), pair[0].min(pair[1]));
                assert!(distance(&back, &wanted) < 1e-12);
                let current = current_gain(a, poles).unwrap();
                assert!(distance(&(a * current), &l) < 1e-12);
                if let Some(listed) = expected.get("L_current") {
                    assert!(distance(&current, &column(listed)) < 1e-12);
                }
                placed += 1;
            }
        }
    }
    assert_eq!(placed, 24);
}

#[test]
fn complex_poles_are_placed_and_mapped() {
    let [a, _] = Discrete::<f64>::paper().joints();
    let l = prediction_gain(&a, Poles::Conjugate { re: 0.5, im: 0.3 }).unwrap();
    let back = error_dynamics(&a, l).complex_eigenvalues();
    assert!((back[0].re - 0.5).abs() < 1e-12 && (back[0].im.abs() - 0.3).abs() < 1e-12);
    // Two half periods make a whole one: the square of the mapped pole.
    let half = Poles::<f64>::Conjugate { re: 0.5, im: 0.3 }.at_period(0.045, 0.0225);
    let Ok(Poles::Conjugate { re, im }) = half else {
        panic!("{half:?}");
    };
    assert!((re * re - im * im - 0.5).abs() < 1e-12 && (2.0 * re * im - 0.3).abs() < 1e-12);
    let mapped = Poles::<f64>::Real(0.05, 0.14).at_period(0.045, 0.001);
    let Ok(Poles::Real(p1, p2)) = mapped else {
        panic!("{mapped:?}");
    };
    assert!((p1.powi(45) - 0.05).abs() < 1e-12 && (p2.powi(45) - 0.14).abs() < 1e-12);
}

#[test]
fn an_observer_that_cannot_be_is_refused_by_name() {
    let [a, _] = Discrete::<f64>::paper().joints();
    let fine = Poles::Real(0.5, 0.6);
    let refused = |poles| prediction_gain(&a, poles).unwrap_err();
    assert_eq!(refused(Poles::Real(0.5, 1.0)), Error::Unstable);
    assert_eq!(refused(Poles::Real(-1.2, 0.1)), Error::Unstable);
    assert_eq!(
        refused(Poles::Conjugate { re: 0.8, im: 0.8 }),
        Error::Unstable
    );
    assert_eq!(refused(Poles::Real(f64::NAN, 0.1)), Error::NotFinite);
    assert_eq!(
        prediction_gain(&(a * f64::NAN), fine),
        Err(Error::NotFinite)
    );
    let deaf = Matrix2::new(1.0, 0.0, 0.1, 0.9);
    assert_eq!(prediction_gain(&deaf, fine), Err(Error::Unobservable));
    let flat = Matrix2::new(1.0, 1.0, 0.5, 0.5);
    assert_eq!(current_gain(&flat, fine), Err(Error::NotInvertible));
    assert_eq!(
        to_current(&flat, Vector2::new(0.1, 0.1)),
        Err(Error::NotInvertible)
    );
    assert_eq!(
        Poles::Real(-0.1, 0.5).at_period(0.045, 0.001),
        Err(Error::Negative)
    );
}

#[test]
fn weights_are_those_of_equation_8() {
    let weights = Weights::<f64>::paper();
    let q: Matrix4<f64> = matrix(at(&["lqr", "Q"]));
    let r: Matrix2<f64> = matrix(at(&["lqr", "R"]));
    assert_eq!(Vector4::from(weights.q), q.diagonal());
    assert_eq!(Vector2::from(weights.r), r.diagonal());
}
