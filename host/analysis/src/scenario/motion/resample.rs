//! Samples of any spacing as points of a stream, evenly spaced, with speeds and
//! accelerations.
//!
//! Samples farther apart than a point are joined by a cubic spline, with the file's speeds
//! or continuous accelerations; each of them is a point. Closer ones are smoothed, so that
//! rounding in the file does not become acceleration: a parabola is fitted to the samples
//! around each point. Each stretch between gaps longer than a point is of one kind; a gap
//! between two dense stretches is joined by the spline, from speed to speed.
//!
//! A motion that begins or ends with a speed gets a run-up or a run-out: a smooth path from
//! rest to that speed and acceleration.

use armbridge_shared::JOINTS;
use nalgebra::{Matrix3, Vector3};

use super::samples::Sample;

/// One number for each joint.
type Joints = [f64; JOINTS];

/// A point of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Knot {
    /// Time in s.
    pub(super) at_s: f64,
    /// Angles in rad.
    pub(super) q: Joints,
    /// Speeds in rad/s.
    pub(super) dq: Joints,
    /// Accelerations in rad/s².
    pub(super) ddq: Joints,
}

/// Points at most `spacing_s` apart, from time 0 to the samples' duration.
pub(super) fn resample(samples: &[Sample], spacing_s: f64) -> Vec<Knot> {
    let start_s = samples[0].at_s;
    let mut knots = Vec::new();
    // Ends of dense stretches, and the samples between them.
    let mut sparse: Vec<Sample> = Vec::new();
    for stretch in samples.chunk_by(|a, b| intervals(b.at_s - a.at_s, spacing_s) < 1.5) {
        if !is_dense(stretch, spacing_s) {
            sparse.extend(stretch);
            continue;
        }
        let smooth = smoothed(stretch, start_s, spacing_s);
        let (first, last) = (smooth[0], smooth[smooth.len() - 1]);
        if !sparse.is_empty() {
            sparse.push(end_of(&first, start_s));
            append(&mut knots, interpolated(&sparse, start_s, spacing_s));
        }
        append(&mut knots, smooth);
        sparse = vec![end_of(&last, start_s)];
    }
    if sparse.len() > 1 {
        append(&mut knots, interpolated(&sparse, start_s, spacing_s));
    }
    knots
}

/// Whether samples without a gap are closer than the points, and enough for a parabola.
fn is_dense(stretch: &[Sample], spacing_s: f64) -> bool {
    let duration_s = stretch[stretch.len() - 1].at_s - stretch[0].at_s;
    stretch.len() > 3 && duration_s / ((stretch.len() - 1) as f64) < spacing_s
}

/// The end of a dense stretch as a sample, with its speed.
fn end_of(knot: &Knot, start_s: f64) -> Sample {
    Sample {
        at_s: start_s + knot.at_s,
        angle_rad: knot.q,
        speed_rad_s: Some(knot.dq),
        byte: 0,
    }
}

/// Appends points, the first of which may be the last one again.
fn append(knots: &mut Vec<Knot>, more: Vec<Knot>) {
    let is_joined = !knots.is_empty();
    knots.extend(more.into_iter().skip(usize::from(is_joined)));
}

/// Number of intervals of at most `spacing_s` in a time.
fn intervals(time_s: f64, spacing_s: f64) -> f64 {
    /// Times of samples are rounded: 0.1 s may be a little more than two of 0.05 s.
    const ROUNDING: f64 = 1e-6;
    (time_s / spacing_s - ROUNDING).ceil().max(1.0)
}

/// A parabola through the samples around each point; time 0 is at `start_s`.
fn smoothed(samples: &[Sample], start_s: f64, spacing_s: f64) -> Vec<Knot> {
    let first_s = samples[0].at_s;
    let duration_s = samples[samples.len() - 1].at_s - first_s;
    let count = intervals(duration_s, spacing_s);
    let half_s = 0.5 * duration_s / count;
    let knot = |number: u32| {
        let centre_s = first_s + duration_s * f64::from(number) / count;
        // At least five samples: a parabola has three numbers.
        let middle = samples.partition_point(|sample| sample.at_s < centre_s);
        let first = samples.partition_point(|sample| sample.at_s < centre_s - half_s);
        let last = samples.partition_point(|sample| sample.at_s <= centre_s + half_s);
        let first = first.min(middle.saturating_sub(2));
        let last = last.max((middle + 3).min(samples.len()));
        let first = first.min(last.saturating_sub(5));
        let window = &samples[first..last.max((first + 5).min(samples.len()))];
        let mut knot = Knot {
            at_s: centre_s - start_s,
            ..Knot::default()
        };
        for joint in 0..JOINTS {
            let angles = window
                .iter()
                .map(|s| (s.at_s - centre_s, s.angle_rad[joint]));
            let [q, dq, ddq] = parabola(angles);
            let speeds: Option<Vec<(f64, f64)>> = window
                .iter()
                .map(|s| Some((s.at_s - centre_s, s.speed_rad_s?[joint])))
                .collect();
            let (dq, ddq) = match speeds {
                Some(speeds) => {
                    let [dq, ddq, _] = parabola(speeds.into_iter());
                    (dq, ddq)
                }
                None => (dq, ddq),
            };
            (knot.q[joint], knot.dq[joint], knot.ddq[joint]) = (q, dq, ddq);
        }
        knot
    };
    (0..=count as u32).map(knot).collect()
}

/// Value, slope and second derivative at 0 of the parabola of least squares.
fn parabola(points: impl Iterator<Item = (f64, f64)>) -> [f64; 3] {
    let points: Vec<(f64, f64)> = points.collect();
    let widest = points.iter().map(|(t, _)| t.abs()).fold(1e-9, f64::max);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (t, value) in &points {
        let x = t / widest;
        let row = Vector3::new(1.0, x, x * x);
        normal += row * row.transpose();
        right += row * *value;
    }
    let fit = normal.lu().solve(&right);
    let mean = points.iter().map(|(_, value)| value).sum::<f64>() / points.len().max(1) as f64;
    fit.map_or([mean, 0.0, 0.0], |fit| {
        [fit[0], fit[1] / widest, 2.0 * fit[2] / (widest * widest)]
    })
}

/// A cubic spline through the samples, with points at them and evenly between them; time 0
/// is at `start_s`.
fn interpolated(samples: &[Sample], start_s: f64, spacing_s: f64) -> Vec<Knot> {
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

/// Speed in rad/s below which a motion begins at rest.
const REST_RAD_S: f64 = 0.005;

/// Points from rest to a speed and an acceleration at time 0, without that point; empty if
/// there is none to reach.
pub(super) fn run_up(to: &Knot, spacing_s: f64, acceleration_rad_s2: f64) -> Vec<Knot> {
    /// Shortest run-up in s.
    const LEAST_S: f64 = 0.3;
    /// Share of the permitted acceleration.
    const SHARE: f64 = 0.5;

    let largest = |values: &Joints| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let (speed, acceleration) = (largest(&to.dq), largest(&to.ddq));
    if speed < REST_RAD_S {
        return Vec::new();
    }
    // The speed grows by a smooth step, whose steepest slope is 1.875 times the mean.
    let room = (SHARE * acceleration_rad_s2 - acceleration).max(0.2 * acceleration_rad_s2);
    let length_s = (1.875 * speed / room).max(LEAST_S).max(2.0 * spacing_s);
    let count = intervals(length_s, spacing_s);
    let knot = |number: u32| {
        let x = f64::from(number) / count;
        // Integral, value and slope of the smooth step, and of x³ - x², which ends with a
        // slope of 1: the acceleration.
        let step = [
            x.powi(4) * (2.5 + x * (-3.0 + x)) - 0.5,
            x.powi(3) * (10.0 + x * (-15.0 + 6.0 * x)),
            30.0 * x * x * (1.0 - x).powi(2),
        ];
        let bend = [
            x.powi(3) * (0.25 * x - 1.0 / 3.0) + 1.0 / 12.0,
            x * x * (x - 1.0),
            x * (3.0 * x - 2.0),
        ];
        let mut knot = Knot {
            at_s: to.at_s - length_s * (1.0 - x),
            ..*to
        };
        for joint in 0..JOINTS {
            let (v, a) = (to.dq[joint], to.ddq[joint]);
            knot.q[joint] += length_s * (v * step[0] + a * length_s * bend[0]);
            knot.dq[joint] = v * step[1] + a * length_s * bend[1];
            knot.ddq[joint] = v * step[2] / length_s + a * bend[2];
        }
        knot
    };
    (0..count as u32).map(knot).collect()
}

/// Points from a speed to rest, without that at which it begins: a run-up in reverse.
pub(super) fn run_out(from: &Knot, spacing_s: f64, acceleration_rad_s2: f64) -> Vec<Knot> {
    let reversed = |knot: &Knot| Knot {
        at_s: -knot.at_s,
        dq: knot.dq.map(|speed| -speed),
        ..*knot
    };
    let knots = run_up(&reversed(from), spacing_s, acceleration_rad_s2);
    knots.iter().rev().map(reversed).collect()
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn a_run_up_reaches_speed_and_acceleration_from_rest() {
        let to = Knot {
            at_s: 0.0,
            q: [0.2, 0.0],
            dq: [0.0, 0.63],
            ddq: [-1.97, 0.0],
        };
        let knots = run_up(&to, 0.002, 20.0);
        let first = knots[0];
        assert!(
            first.dq.iter().chain(&first.ddq).all(|x| x.abs() < 1e-12),
            "{first:?}"
        );
        // Each point follows from the one before by its derivatives.
        for pair in knots.iter().chain([&to]).collect::<Vec<_>>().windows(2) {
            let dt = pair[1].at_s - pair[0].at_s;
            for joint in 0..JOINTS {
                let mean = 0.5 * (pair[0].dq[joint] + pair[1].dq[joint]);
                let moved = pair[1].q[joint] - pair[0].q[joint];
                assert!((moved - mean * dt).abs() < 1e-4 * dt, "{pair:?}");
                let mean = 0.5 * (pair[0].ddq[joint] + pair[1].ddq[joint]);
                let gained = pair[1].dq[joint] - pair[0].dq[joint];
                assert!((gained - mean * dt).abs() < 2e-2 * dt, "{pair:?}");
            }
        }
        let out = run_out(&to, 0.01, 20.0);
        let last = out[out.len() - 1];
        assert!(
            last.at_s > 0.29 && last.dq.iter().all(|x| x.abs() < 1e-12),
            "{last:?}"
        );
        let at_rest = Knot {
            dq: [0.0; JOINTS],
            ..to
        };
        assert!(run_up(&at_rest, 0.01, 20.0).is_empty());
    }
}
