//! Initial guess of the search: parameters that enter the equations linearly.
//!
//! The equation of motion is multiplied by a bump function that vanishes with its slope at
//! both ends, and summed over a segment in which a joint slides one way. Integration by parts
//! moves the derivatives to the bump, so that neither acceleration nor speed is needed. The
//! result is linear in inertia, friction, gravity, gain and offset: least squares solves it
//! directly, near enough for the search.

use armbridge_servo::JOINTS;
use nalgebra::{DMatrix, DVector};

use super::arm::KnownParameters;
use super::dataset::Trace;
use super::quantity::{COUNT, Quantity};

/// Half the length of a segment, in ticks.
const HALF_SEGMENT: usize = 80;
/// Distance between segments, in ticks.
const STRIDE: usize = 20;
/// Speed in rad/s above which a joint counts as sliding.
const SLIDES_RAD_S: f64 = 0.15;
/// Counts from neutral that may be within a dead zone.
const DEAD_ZONE_COUNTS: f64 = 45.0;
/// Assumed delay in ticks.
const DELAY_TICKS: usize = 3;

/// Failed initial guess: the linear equations of a joint have no physical solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InitialGuessError {
    /// Joint, from 0.
    pub joint: usize,
    /// Number of usable segments.
    pub segments: usize,
    /// Solution for the motor gain in PWM counts per N m.
    pub gain: f64,
}

/// Bump function and its first two derivatives by the tick, at a tick of the segment.
fn bump(index: usize) -> [f64; 3] {
    let x = (index as f64 - HALF_SEGMENT as f64) / HALF_SEGMENT as f64;
    let rest = 1.0 - x * x;
    let step = 1.0 / HALF_SEGMENT as f64;
    [
        rest.powi(3),
        -6.0 * x * rest.powi(2) * step,
        (-6.0 * rest.powi(2) + 24.0 * x * x * rest) * step * step,
    ]
}

/// Columns: inertia, viscous friction, Coulomb friction, own gravity, gravity by the encoder
/// zero, motor gain, motor offset.
const COLUMNS: usize = 7;

/// Equation over a segment: its columns, and its right side.
fn segment(
    trace: &Trace,
    known: &KnownParameters,
    mean: &[f64; COUNT],
    joint: usize,
    first: usize,
) -> Option<([f64; COLUMNS], f64)> {
    let period_s = known.period_s;
    let zero = [0, 1].map(|j| Quantity::Zero.value(mean[Quantity::Zero.index(j)]));
    let g2 = Quantity::Gravity.value(mean[Quantity::Gravity.index(1)]);
    let [p, e] = known.coupling(g2);
    let mut angles = [[0.0; 2 * HALF_SEGMENT + 1]; JOINTS];
    for (j, angles) in angles.iter_mut().enumerate() {
        for (index, angle) in angles.iter_mut().enumerate() {
            let count = trace.counts.get(first + index)?[j]?;
            *angle = (f64::from(count) - zero[j]) * known.rad_per_count[j];
        }
    }
    // Speeds of quarters of the segment.
    let quarter = HALF_SEGMENT / 2;
    let mean_of = |j: usize, part: usize| -> f64 {
        angles[j][part * quarter..(part + 1) * quarter]
            .iter()
            .sum::<f64>()
            / quarter as f64
    };
    let speed = |j: usize, part: usize| {
        (mean_of(j, part + 1) - mean_of(j, part)) / (quarter as f64 * period_s)
    };
    let direction = speed(joint, 0).signum();
    if (0..3).any(|part| speed(joint, part) * direction < SLIDES_RAD_S) {
        return None;
    }
    let gravity_sign = known.gravity_sign();
    let (mut row, mut right) = ([0.0; COLUMNS], 0.0);
    let together = angles[0].iter().zip(&angles[1]).map(|(a, b)| [*a, *b]);
    for (index, q) in together.enumerate() {
        let [weight, slope, curve] = bump(index);
        let part = (index / quarter).min(3).saturating_sub(1);
        let v = [speed(0, part.min(2)), speed(1, part.min(2))];
        let acceleration = q[joint] * curve / (period_s * period_s);
        let viscous = -q[joint] * slope / period_s;
        let ((sin1, cos1), (sin2, cos2)) = (q[0].sin_cos(), q[1].sin_cos());
        let h = sin2 * (2.0 * cos2 * e + p);
        row[0] += acceleration;
        row[1] += viscous;
        row[2] += weight * direction;
        if joint == 0 {
            row[3] -= gravity_sign * weight * sin1;
            row[4] -= gravity_sign * weight * cos1;
            right += weight * (gravity_sign * sin1 * g2 * cos2 + h * v[0] * v[1]);
            right -= acceleration * (p * cos2 + e * cos2 * cos2);
        } else {
            row[4] -= gravity_sign * weight * cos1 * cos2;
            right += weight * (gravity_sign * g2 * cos1 * sin2 - 0.5 * h * v[0] * v[0]);
        }
        let sent = trace.pwm_at((first + index) as i64 - DELAY_TICKS as i64, joint);
        let counts = f64::from(sent) - 1000.0;
        if counts.abs() > DEAD_ZONE_COUNTS {
            row[5] -= weight * counts;
            row[6] += weight;
        }
    }
    Some((row, right))
}

/// Initial coordinates: the solution of the linear equations, `mean` for the others.
///
/// # Errors
/// If a joint moves too little, or its motor gain has the wrong sign.
pub(super) fn initial_guess(
    traces: &[Trace],
    known: &KnownParameters,
    mean: &[f64; COUNT],
) -> Result<[f64; COUNT], InitialGuessError> {
    let mut coordinates = *mean;
    for joint in 0..known.joints {
        let rows: Vec<_> = traces
            .iter()
            .flat_map(|trace| {
                let last = trace.counts.len().saturating_sub(2 * HALF_SEGMENT);
                (0..last)
                    .step_by(STRIDE)
                    .filter_map(move |first| segment(trace, known, mean, joint, first))
            })
            .collect();
        // Joint 2's own gravity fixes the scale; its effect on joint 1 is too small to be
        // more informative than the prior, here.
        let used: &[usize] = if joint == 0 {
            &[0, 1, 2, 3, 4, 6]
        } else {
            &[0, 1, 2, 4, 5, 6]
        };
        let sign = known.rad_per_count[joint].signum();
        let prior_gain = Quantity::Gain.value(mean[Quantity::Gain.index(joint)]);
        let error = InitialGuessError {
            joint,
            segments: rows.len(),
            gain: 0.0,
        };
        if rows.len() < 5 * COLUMNS {
            return Err(error);
        }
        let scale: Vec<f64> = used
            .iter()
            .map(|&column| {
                rows.iter()
                    .map(|row| row.0[column].powi(2))
                    .sum::<f64>()
                    .sqrt()
                    .max(1e-30)
            })
            .collect();
        let matrix = DMatrix::from_fn(rows.len(), used.len(), |i, j| rows[i].0[used[j]] / scale[j]);
        let right = DVector::from_fn(rows.len(), |i, _| {
            let (row, right) = &rows[i];
            if joint == 0 {
                right - row[5] * sign / prior_gain
            } else {
                *right
            }
        });
        let solution = matrix
            .svd(true, true)
            .solve(&right, 1e-9)
            .map_err(|_| error)?;
        let coefficient = |column: usize| {
            used.iter()
                .position(|&c| c == column)
                .map_or(0.0, |j| solution[j] / scale[j])
        };
        let gain = if joint == 0 {
            prior_gain
        } else {
            sign / coefficient(5)
        };
        if !(gain > 50.0 && gain < 20_000.0) {
            return Err(InitialGuessError { gain, ..error });
        }
        let mut set = |quantity: Quantity, value: f64, low: f64, high: f64| {
            coordinates[quantity.index(joint)] = quantity.coordinate(value.clamp(low, high));
        };
        set(Quantity::Inertia, coefficient(0), 2e-3, 0.5);
        set(Quantity::Viscous, coefficient(1), 0.01, 5.0);
        set(Quantity::Coulomb, coefficient(2), 3e-3, 0.5);
        if joint == 0 {
            set(Quantity::Gravity, coefficient(3), 0.02, 5.0);
        }
        set(Quantity::Gain, gain, 100.0, 10_000.0);
        set(
            Quantity::Offset,
            coefficient(6) * gain * sign,
            -100.0,
            100.0,
        );
        // Error of the zero: gravity torque at the middle.
        let gravity = if joint == 0 {
            coefficient(3) + Quantity::Gravity.value(mean[Quantity::Gravity.index(1)])
        } else {
            Quantity::Gravity.value(mean[Quantity::Gravity.index(1)])
        };
        let off_rad = coefficient(4) / gravity.max(0.02);
        let zero = Quantity::Zero.value(mean[Quantity::Zero.index(joint)]);
        set(
            Quantity::Zero,
            zero - off_rad / known.rad_per_count[joint],
            zero - 60.0,
            zero + 60.0,
        );
    }
    Ok(coordinates)
}
