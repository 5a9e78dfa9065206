use super::*;

fn circle(period_s: f64, rounded: bool, with_speed: bool) -> Vec<Sample> {
    let turn = std::f64::consts::TAU / 2.0;
    let samples = (0..).map(|k| f64::from(k) * period_s);
    let samples = samples.take_while(|t| *t <= 4.0 + 1e-9);
    let sample = |at_s: f64| {
        let (sin, cos) = (turn * at_s).sin_cos();
        let round = |x: f64| if rounded { (x * 1e4).round() / 1e4 } else { x };
        Sample {
            at_s,
            angle_rad: [round(0.2 * cos), round(0.2 * sin)],
            speed_rad_s: with_speed.then_some([-0.2 * turn * sin, 0.2 * turn * cos]),
            byte: 0,
        }
    };
    samples.map(sample).collect()
}

/// Largest error of angle in rad, speed in rad/s and acceleration in rad/s².
fn errors(knots: &[Knot]) -> [f64; 3] {
    let turn = std::f64::consts::TAU / 2.0;
    let mut worst = [0.0_f64; 3];
    for knot in knots {
        let cos = (turn * knot.at_s).cos();
        let pairs = [
            (knot.q[0], 0.2 * cos),
            (knot.dq[1], 0.2 * turn * cos),
            (knot.ddq[0], -0.2 * turn * turn * cos),
        ];
        for (worst, (a, b)) in worst.iter_mut().zip(pairs) {
            *worst = worst.max((a - b).abs());
        }
    }
    worst
}

#[test]
fn dense_and_sparse_samples_make_the_same_circle() {
    for (period_s, rounded, with_speed) in [
        (0.001, true, false),
        (0.001, true, true),
        (0.01, false, false),
        (0.025, false, false),
        (0.1, false, false),
        (0.1, false, true),
    ] {
        let knots = resample(&circle(period_s, rounded, with_speed), 0.05);
        assert!((80..=82).contains(&knots.len()), "{}", knots.len());
        assert!((knots[knots.len() - 1].at_s - 4.0).abs() < 1e-6);
        let [q, dq, ddq] = errors(&knots);
        assert!(
            q < 6e-4 && dq < 0.02 && ddq < 0.7,
            "{period_s}: {q} {dq} {ddq}"
        );
    }
}

/// The first joint moves as a sine with a period of 4 s.
fn sine(times_s: impl Iterator<Item = f64>) -> Vec<Sample> {
    let sample = |at_s: f64| Sample {
        at_s,
        angle_rad: [0.3 * (at_s * std::f64::consts::FRAC_PI_2).sin(), 0.0],
        speed_rad_s: None,
        byte: 0,
    };
    times_s.map(sample).collect()
}

/// Largest error of angle and speed of that motion.
fn sine_errors(knots: &[Knot]) -> [f64; 2] {
    let errors = knots.iter().map(|knot| {
        let rate = std::f64::consts::FRAC_PI_2;
        let (sin, cos) = (rate * knot.at_s).sin_cos();
        [knot.q[0] - 0.3 * sin, knot.dq[0] - 0.3 * rate * cos].map(f64::abs)
    });
    errors.fold([0.0; 2], |[a, b], [c, d]| [a.max(c), b.max(d)])
}

/// Samples each 10 ms, without those of 1 s of the motion.
#[test]
fn a_gap_in_dense_samples_is_joined_by_a_spline() {
    let times = (0..=400).map(|k| f64::from(k) * 0.01);
    let dense = times.filter(|t| *t < 1.505 || *t > 2.495);
    let knots = resample(&sine(dense), 0.05);
    let times: Vec<f64> = knots.iter().map(|knot| knot.at_s).collect();
    let widest = times.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(widest.clone().all(|s| s > 1e-6 && s < 0.05 + 1e-6));
    assert!((times[times.len() - 1] - 4.0).abs() < 1e-9);
    let [q, dq] = sine_errors(&knots);
    assert!(q < 6e-3 && dq < 0.02, "{q} {dq}");
}

/// A pause between dense stretches has samples of its own, each a point.
#[test]
fn sparse_samples_between_dense_ones_are_points() {
    let dense = |from: i32| (from..=from + 100).map(|k| f64::from(k) * 0.01);
    let sparse = (1..=10).map(|k| 1.0 + f64::from(k) * 0.09);
    let knots = resample(&sine(dense(0).chain(sparse).chain(dense(200))), 0.05);
    for at_s in [1.09, 1.45, 1.9] {
        let is_there = |knot: &Knot| (knot.at_s - at_s).abs() < 1e-9;
        assert!(knots.iter().any(is_there), "{at_s}");
    }
    let [q, dq] = sine_errors(&knots);
    assert!(q < 1e-3 && dq < 6e-3, "{q} {dq}");
}

#[test]
fn a_motion_that_begins_and_ends_with_a_pause_is_at_rest_there() {
    let rows = [(0.0, 0.0), (1.0, 0.0), (1.1, 0.2), (1.2, 0.0), (2.0, 0.0)];
    let samples = rows.map(|(at_s, angle_rad)| Sample {
        at_s,
        angle_rad: [angle_rad, 0.0],
        speed_rad_s: None,
        byte: 0,
    });
    let knots = resample(&samples, 0.05);
    for end in [knots[0], knots[knots.len() - 1]] {
        assert!(end.dq.iter().all(|speed| speed.abs() < 1e-12), "{end:?}");
    }
}
