//! Samples of any spacing as points of a stream, evenly spaced, with speeds and
//! accelerations.
//!
//! Samples farther apart than a point are joined by a cubic spline, with the file's speeds
//! or continuous accelerations; each of them is a point. Closer ones are smoothed, so that
//! rounding in the file does not become acceleration: a parabola is fitted to the samples
//! around each point. Each stretch between gaps longer than a point is of one kind; a gap
//! between two dense stretches is joined by the spline, from speed to speed.

mod spline;
#[cfg(test)]
mod tests;

use armbridge_servo::JOINTS;
use nalgebra::{Matrix3, Vector3};

use super::samples::Sample;
use spline::interpolated;

/// One number for each joint.
pub(super) type Joints = [f64; JOINTS];

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
pub(super) fn intervals(time_s: f64, spacing_s: f64) -> f64 {
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
