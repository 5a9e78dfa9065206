//! Properties of the estimators, apart from any plant.

use armbridge_control::arm::{Discrete, Parameters, State};
use armbridge_control::design::placement::Poles;
use armbridge_control::design::stability::Eigenvalue;
use armbridge_control::estimate::{Config, Error, Estimator, Form, Luenberger};
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2x4, Matrix4x2, Vector2, Vector4};

/// A made-up motion: angles, and torques that have nothing to do with them.
fn motion(tick: u32) -> ([f64; JOINTS], Vector2<f64>) {
    let t = f64::from(tick) * 0.001;
    let q = [0.3 * (3.0 * t).sin(), 0.2 * (5.0 * t).cos()];
    (q, Vector2::new(0.1 * (7.0 * t).sin(), -0.05))
}

#[test]
fn the_paper_s_observer_is_equation_11() {
    let Discrete { a, b } = Discrete::<f64>::paper();
    let c = Matrix2x4::identity();
    #[rustfmt::skip]
    let l = Matrix4x2::new(
        0.29, 0.0,
        0.0, 0.34,
        0.72, 0.0,
        0.0, 0.34,
    );
    let observer = Estimator::Luenberger(Luenberger::<f64>::paper().unwrap());
    let arm = Parameters::paper();
    let mut estimate = observer.at_rest(Vector2::zeros());
    let mut x = Vector4::zeros();
    for tick in 0..200 {
        let (q, torque) = motion(45 * tick);
        let corrected = observer.correct(&mut estimate, q.map(Some)).to_vector();
        assert!((corrected - x).amax() < 1e-12, "tick {tick}");
        x = a * x + b * torque + l * (Vector2::from(q) - c * x);
        assert!((observer.advance(&arm, &mut estimate, torque).to_vector() - x).amax() < 1e-12);
    }
}

fn estimators() -> [Config<f64>; 3] {
    [
        Config::standing(),
        Config::FiniteDifference { filter_s: 0.02 },
        Config::FiniteDifference { filter_s: 0.0 },
    ]
}

#[test]
fn an_arm_held_aside_is_seen_at_rest() {
    let arm = Parameters::<f64>::paper();
    let q = Vector2::new(0.5, -0.4);
    for config in estimators() {
        for measured in [[Some(q.x), Some(q.y)], [None, None]] {
            let estimator = config.build(&arm, 0.001).unwrap();
            let mut estimate = estimator.at_rest(q);
            for _ in 0..500 {
                let state = estimator.correct(&mut estimate, measured);
                let ahead = estimator.advance(&arm, &mut estimate, arm.gravity(q));
                let error = (state.to_vector() - State::at_rest(q).to_vector()).amax();
                assert!(error < 1e-9, "{config:?}: {error:e}");
                assert!(ahead.dq.amax() < 1e-9);
            }
        }
    }
}

#[test]
fn missing_samples_are_predicted_through() {
    let arm = Parameters::<f64>::paper();
    for config in estimators() {
        let estimator = config.build(&arm, 0.001).unwrap();
        let mut estimate = estimator.at_rest(Vector2::zeros());
        let mut ahead = State::at_rest(Vector2::zeros());
        for tick in 0..100 {
            let (q, torque) = motion(tick);
            let state = estimator.correct(&mut estimate, [Some(q[0]), None]);
            assert_eq!(state.q.y, ahead.q.y, "joint 2 is the model's");
            assert_eq!(state.dq.y, ahead.dq.y);
            ahead = estimator.advance(&arm, &mut estimate, torque);
        }
    }
    // A difference over a gap is taken over the whole of it.
    let plain = Config::FiniteDifference { filter_s: 0.0 };
    let estimator = plain.build(&arm, 0.001).unwrap();
    let mut estimate = estimator.at_rest(Vector2::zeros());
    estimator.correct(&mut estimate, [None, None]);
    estimator.advance(&arm, &mut estimate, Vector2::zeros());
    let state = estimator.correct(&mut estimate, [Some(0.002), Some(-0.004)]);
    assert!((state.dq - Vector2::new(1.0, -2.0)).amax() < 1e-12);
}

#[test]
fn f32_stays_close_to_f64_over_ten_seconds() {
    let configs: [(Config<f64>, Config<f32>); 2] = [
        (Config::standing(), Config::standing()),
        (
            Config::FiniteDifference { filter_s: 0.02 },
            Config::FiniteDifference { filter_s: 0.02 },
        ),
    ];
    for (double, single) in configs {
        let (arm, rough_arm) = (Parameters::paper(), Parameters::paper());
        let exact: Estimator<f64> = double.build(&arm, 0.001).unwrap();
        let close: Estimator<f32> = single.build(&rough_arm, 0.001).unwrap();
        let mut estimate = exact.at_rest(Vector2::zeros());
        let mut rough = close.at_rest(Vector2::zeros());
        for tick in 0..10_000 {
            let (q, torque) = motion(tick);
            let x = exact.correct(&mut estimate, q.map(Some));
            let y = close.correct(&mut rough, q.map(|q| Some(q as f32)));
            exact.advance(&arm, &mut estimate, torque);
            close.advance(&rough_arm, &mut rough, torque.cast());
            let angle = (x.q - y.q.cast()).amax();
            let speed = (x.dq - y.dq.cast()).amax();
            // Angles keep their digits; a difference over 1 ms loses three.
            assert!(
                angle < 2e-6 && speed < 2e-3,
                "tick {tick}: {angle:e} {speed:e}"
            );
        }
    }
}

#[test]
fn an_estimator_that_cannot_be_is_refused_by_name() {
    let arm = Parameters::<f64>::paper();
    let refused = |config: Config<f64>, period_s| config.build(&arm, period_s).unwrap_err();
    assert_eq!(refused(Config::standing(), 0.0), Error::Period);
    assert_eq!(refused(Config::standing(), f64::NAN), Error::Period);
    let filter_s = -0.1;
    assert_eq!(
        refused(Config::FiniteDifference { filter_s }, 0.001),
        Error::Filter
    );
    let poles_45ms = [Poles::Real(0.1, 0.2), Poles::Real(0.1, 1.0)];
    assert_eq!(
        refused(
            Config::Luenberger {
                form: Form::Current,
                poles_45ms
            },
            0.001
        ),
        Error::Unstable(Eigenvalue { re: 1.0, im: 0.0 })
    );
}
