use super::*;
use crate::estimate::{Config, Estimator};

fn build<T: Real>() -> Estimator<T> {
    let arm = Parameters::paper();
    Config::kalman().build(&arm, T::lit(0.001)).unwrap()
}

/// A motion that no model explains: the filter must bear it.
fn sample(tick: u32) -> [f64; JOINTS] {
    let t = f64::from(tick) * 1e-3;
    [0.3 * (1.1 * t).sin(), 0.2 * (1.7 * t).cos()]
}

#[test]
fn a_push_is_found_and_the_arm_at_rest_is_seen_at_rest() {
    let arm = Parameters::<f64>::paper();
    let (q, push) = (Vector2::new(0.3, -0.2), Vector2::new(0.05, -0.03));
    let filter = build();
    let mut estimate = filter.at_rest(q);
    let mut state = State::at_rest(q);
    for _ in 0..3_000 {
        state = filter.correct(&mut estimate, [Some(q.x), Some(q.y)]);
        filter.advance(&arm, &mut estimate, arm.gravity(q) - push);
    }
    assert!((estimate.disturbance() - push).amax() < 1e-6);
    assert!((state.q - q).amax() < 1e-6 && state.dq.amax() < 1e-6);
}

/// The arm is held against a motor that pushes as hard as it can.
#[test]
fn a_disturbance_does_not_wind_up() {
    let filter = build::<f64>();
    let (arm, mut estimate) = (Parameters::paper(), filter.at_rest(Vector2::zeros()));
    for _ in 0..10_000 {
        filter.correct(&mut estimate, [Some(0.0), Some(0.0)]);
        filter.advance(&arm, &mut estimate, Vector2::new(1.2, -1.2));
    }
    assert_eq!(estimate.disturbance(), Vector2::new(-0.5, 0.5));
    // Let go, it is forgotten as fast as it can be seen.
    for _ in 0..300 {
        filter.correct(&mut estimate, [Some(0.0), Some(0.0)]);
        filter.advance(&arm, &mut estimate, Vector2::zeros());
    }
    assert!(estimate.disturbance().amax() < 0.02);
}

#[test]
fn without_samples_the_arm_moves_as_the_model_has_it() {
    let arm = Parameters::<f64>::paper();
    let filter = Config::Kalman(Tuning {
        coulomb_nm: 0.0,
        ..Tuning::standing()
    })
    .build(&arm, 1e-4)
    .unwrap();
    let initial = Vector2::new(0.2, -0.3);
    let mut estimate = filter.at_rest(initial);
    let mut state = State::at_rest(initial);
    for _ in 0..5_000 {
        filter.correct(&mut estimate, [None, None]);
        let ahead = filter.advance(&arm, &mut estimate, Vector2::zeros());
        // Heun's method at the same step.
        let slope = arm.acceleration(&state, Vector2::zeros());
        let euler = State {
            q: state.q + state.dq * 1e-4,
            dq: state.dq + slope * 1e-4,
        };
        let slope = (slope + arm.acceleration(&euler, Vector2::zeros())) * 0.5;
        state.q += (state.dq + euler.dq) * 0.5e-4;
        state.dq += slope * 1e-4;
        assert!((ahead.q - state.q).amax() < 1e-3 * initial.amax());
    }
    assert!(state.q.amax() > 0.4, "it falls: {}", state.q);
}

#[test]
fn single_precision_keeps_the_covariance_and_its_digits_for_ten_minutes() {
    let (exact, close) = (build::<f64>(), build::<f32>());
    let (arm, single) = (Parameters::paper(), Parameters::paper());
    let mut estimate = exact.at_rest(Vector2::zeros());
    let mut rough = close.at_rest(Vector2::zeros());
    for tick in 0..600_000 {
        let q = sample(tick);
        // One sample in five is missing.
        let lost = tick % 5 == 3;
        let x = exact.correct(&mut estimate, q.map(|q| (!lost).then_some(q)));
        let y = close.correct(&mut rough, q.map(|q| (!lost).then_some(q as f32)));
        exact.advance(&arm, &mut estimate, Vector2::new(0.1, -0.1));
        close.advance(&single, &mut rough, Vector2::new(0.1, -0.1));
        assert!((x.q - y.q.cast()).amax() < 1e-5, "tick {tick}");
        assert!((x.dq - y.dq.cast()).amax() < 1e-4, "tick {tick}");
    }
    for joint in rough.joints {
        let p = joint.covariance;
        let minor = p.qq * p.vv - p.qv * p.qv;
        let determinant =
            p.dd * minor - p.qd * (p.qd * p.vv - p.qv * p.vd) + p.vd * (p.qd * p.qv - p.qq * p.vd);
        assert!(p.qq > 0.0 && minor > 0.0 && determinant > 0.0, "{p:?}");
    }
}
