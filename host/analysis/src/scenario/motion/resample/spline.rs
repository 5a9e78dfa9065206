//! Cubic spline through the samples of a motion.

use armbridge_servo::JOINTS;

use super::{Knot, intervals};
use crate::scenario::motion::samples::Sample;

/// A cubic spline through the samples, with points at them and evenly between them; time 0
/// is at `start_s`.
pub(super) fn interpolated(samples: &[Sample], start_s: f64, spacing_s: f64) -> Vec<Knot> {
    let slopes: [Vec<f64>; JOINTS] = core::array::from_fn(|joint| slopes(samples, joint));
    let mut knots = Vec::new();
    for (number, pair) in samples.windows(2).enumerate() {
        let [a, b] = [&pair[0], &pair[1]];
        let width_s = b.at_s - a.at_s;
        let parts = intervals(width_s, spacing_s) as u32;
        let is_last = number + 2 == samples.len();
        for part in 0..parts + u32::from(is_last) {
            let x = f64::from(part) / f64::from(parts);
            let mut knot = Knot {
                at_s: a.at_s - start_s + x * width_s,
                ..Knot::default()
            };
            for (joint, slopes) in slopes.iter().enumerate() {
                let ends = [a.angle_rad[joint], b.angle_rad[joint]];
                let speeds = [slopes[number], slopes[number + 1]];
                let [q, dq, ddq] = hermite(ends, speeds, width_s, x);
                (knot.q[joint], knot.dq[joint], knot.ddq[joint]) = (q, dq, ddq);
            }
            knots.push(knot);
        }
    }
    knots
}

/// Speeds of a joint at the samples: the given ones, or those with which accelerations are
/// continuous. Of a file without speeds, the ends of dense stretches have one.
fn slopes(samples: &[Sample], joint: usize) -> Vec<f64> {
    let given: Option<Vec<f64>> = samples
        .iter()
        .map(|sample| Some(sample.speed_rad_s?[joint]))
        .collect();
    if let Some(given) = given {
        return given;
    }
    let count = samples.len();
    let width = |k: usize| samples[k + 1].at_s - samples[k].at_s;
    let chord = |k: usize| {
        let rise = samples[k + 1].angle_rad[joint] - samples[k].angle_rad[joint];
        rise / width(k)
    };
    let points = || samples.iter().map(|s| (s.at_s, s.angle_rad[joint]));
    let mut slopes = vec![0.0; count];
    // Not against the way to the next sample, and at most three times as fast: unevenly
    // spaced samples would have it overshoot.
    let bounded = |slope: f64, chord: f64| {
        let share = if chord == 0.0 { 0.0 } else { slope / chord };
        chord * share.clamp(0.0, 3.0)
    };
    let first = end_slope(&points().take(END).collect::<Vec<_>>());
    let last = end_slope(&points().rev().take(END).collect::<Vec<_>>());
    let given = |at: usize| samples[at].speed_rad_s.map(|speed| speed[joint]);
    slopes[0] = given(0).unwrap_or_else(|| bounded(first, chord(0)));
    slopes[count - 1] = given(count - 1).unwrap_or_else(|| bounded(last, chord(count - 2)));
    // Thomas's algorithm for a tridiagonal system.
    let (mut above, mut right) = (vec![0.0; count], slopes.clone());
    for k in 1..count - 1 {
        let (before, after) = (width(k - 1), width(k));
        let (low, high) = (after, before);
        let wanted = 3.0 * (after * chord(k - 1) + before * chord(k));
        let pivot = 2.0 * (before + after) - low * above[k - 1];
        above[k] = high / pivot;
        right[k] = (wanted - low * right[k - 1]) / pivot;
    }
    for k in (1..count - 1).rev() {
        slopes[k] = right[k] - above[k] * slopes[k + 1];
    }
    slopes
}

/// Samples that the speed at an end is computed from, if the file has none.
const END: usize = 4;

/// Slope at the first of a few points of the polynomial through all of them.
fn end_slope(points: &[(f64, f64)]) -> f64 {
    let Some(&(at_s, _)) = points.first() else {
        return 0.0;
    };
    let slope = |(number, &(own_s, value)): (usize, &(f64, f64))| {
        let others = points.iter().enumerate();
        // The derivative of Lagrange's polynomial that is 1 at this point and 0 at others.
        let weight = if number == 0 {
            others
                .skip(1)
                .map(|(_, (t, _))| 1.0 / (at_s - t))
                .sum::<f64>()
        } else {
            let others = others.filter(|(other, _)| *other != 0 && *other != number);
            let factors = others.map(|(_, (t, _))| (at_s - t) / (own_s - t));
            factors.product::<f64>() / (own_s - at_s)
        };
        value * weight
    };
    points.iter().enumerate().map(slope).sum()
}

/// Value, slope and second derivative of a cubic, at a fraction `x` of its width.
fn hermite([a, b]: [f64; 2], [da, db]: [f64; 2], width: f64, x: f64) -> [f64; 3] {
    let (da, db) = (da * width, db * width);
    let (c2, c3) = (3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db);
    [
        a + x * (da + x * (c2 + x * c3)),
        (da + x * (2.0 * c2 + x * 3.0 * c3)) / width,
        (2.0 * c2 + 6.0 * c3 * x) / (width * width),
    ]
}
