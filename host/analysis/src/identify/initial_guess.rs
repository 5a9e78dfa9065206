//! Where the search begins: the numbers that enter the equations linearly.
//!
//! Multiplied by a bump that vanishes with its slope at both ends, and summed over a
//! stretch in which a joint slides one way, the equation of motion needs no
//! acceleration and no speed: both pass on to the bump, whose derivatives are known. In
//! inertia, friction, gravity, gain and offset it is linear, so that least squares
//! finds them at once. What is left is near enough for the search proper.

use armbridge_shared::JOINTS;
use nalgebra::{DMatrix, DVector};

use super::arm::Known;
use super::dataset::Trace;
use super::quantity::{COUNT, Quantity};

/// Half the stretch, in ticks.
const HALF: usize = 80;
/// From one stretch to the next, in ticks.
const STRIDE: usize = 20;
/// Speed in rad/s above which a joint surely slides.
const SLIDES_RAD_S: f64 = 0.15;
/// Counts from off within which a motor may be silent.
const SILENT_COUNTS: f64 = 45.0;
/// Delay that is assumed, in ticks.
const DELAY_TICKS: usize = 3;

/// A joint's equation has no solution that an arm can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoStart {
    /// From 0.
    pub joint: usize,
    /// Stretches that were of use.
    pub stretches: usize,
    /// PWM counts per N m that would be.
    pub gain: f64,
}

/// The bump and its first two derivatives by the tick, at a tick of the stretch.
fn bump(index: usize) -> [f64; 3] {
    let x = (index as f64 - HALF as f64) / HALF as f64;
    let rest = 1.0 - x * x;
    let step = 1.0 / HALF as f64;
    [
        rest.powi(3),
        -6.0 * x * rest.powi(2) * step,
        (-6.0 * rest.powi(2) + 24.0 * x * x * rest) * step * step,
    ]
}

/// Columns: inertia, viscous, Coulomb, own gravity, gravity by the zero, gain, offset.
const COLUMNS: usize = 7;

/// The equation over a stretch: its columns, and what is known of it.
fn stretch(
    trace: &Trace,
    known: &Known,
    mean: &[f64; COUNT],
    joint: usize,
    first: usize,
) -> Option<([f64; COLUMNS], f64)> {
    let period_s = known.period_s;
    let zero = [0, 1].map(|j| Quantity::Zero.value(mean[Quantity::Zero.at(j)]));
    let g2 = Quantity::Gravity.value(mean[Quantity::Gravity.at(1)]);
    let [p, e] = known.reach(g2);
    let mut angles = [[0.0; 2 * HALF + 1]; JOINTS];
    for (j, angles) in angles.iter_mut().enumerate() {
        for (index, angle) in angles.iter_mut().enumerate() {
            let count = trace.counts.get(first + index)?[j]?;
            *angle = (f64::from(count) - zero[j]) * known.rad_per_count[j];
        }
    }
    // Speeds of quarters of the stretch.
    let quarter = HALF / 2;
    let mean_of = |j: usize, part: usize| -> f64 {
        angles[j][part * quarter..(part + 1) * quarter]
            .iter()
            .sum::<f64>()
            / quarter as f64
    };
    let speed = |j: usize, part: usize| {
        (mean_of(j, part + 1) - mean_of(j, part)) / (quarter as f64 * period_s)
    };
    let way = speed(joint, 0).signum();
    if (0..3).any(|part| speed(joint, part) * way < SLIDES_RAD_S) {
        return None;
    }
    let stands = known.stands();
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
        row[2] += weight * way;
        if joint == 0 {
            row[3] -= stands * weight * sin1;
            row[4] -= stands * weight * cos1;
            right += weight * (stands * sin1 * g2 * cos2 + h * v[0] * v[1]);
            right -= acceleration * (p * cos2 + e * cos2 * cos2);
        } else {
            row[4] -= stands * weight * cos1 * cos2;
            right += weight * (stands * g2 * cos1 * sin2 - 0.5 * h * v[0] * v[0]);
        }
        let sent = trace.pwm_at((first + index) as i64 - DELAY_TICKS as i64, joint);
        let counts = f64::from(sent) - 1000.0;
        if counts.abs() > SILENT_COUNTS {
            row[5] -= weight * counts;
            row[6] += weight;
        }
    }
    Some((row, right))
}

/// The coordinates to begin with: `mean`, and in place of it what is found.
///
/// # Errors
/// If nothing moved enough, or the motor pushes the wrong way.
pub(super) fn start(
    traces: &[Trace],
    known: &Known,
    mean: &[f64; COUNT],
) -> Result<[f64; COUNT], NoStart> {
    let mut at = *mean;
    for joint in 0..JOINTS {
        let rows: Vec<_> = traces
            .iter()
            .flat_map(|trace| {
                let last = trace.counts.len().saturating_sub(2 * HALF);
                (0..last)
                    .step_by(STRIDE)
                    .filter_map(move |first| stretch(trace, known, mean, joint, first))
            })
            .collect();
        // Joint 2's own gravity is what fixes the scale; what it does to joint 1 is too
        // little to tell more than the prior does, here.
        let used: &[usize] = if joint == 0 {
            &[0, 1, 2, 3, 4, 6]
        } else {
            &[0, 1, 2, 4, 5, 6]
        };
        let turn = known.rad_per_count[joint].signum();
        let believed = Quantity::Gain.value(mean[Quantity::Gain.at(joint)]);
        let nothing = NoStart {
            joint,
            stretches: rows.len(),
            gain: 0.0,
        };
        if rows.len() < 5 * COLUMNS {
            return Err(nothing);
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
                right - row[5] * turn / believed
            } else {
                *right
            }
        });
        let solution = matrix
            .svd(true, true)
            .solve(&right, 1e-9)
            .map_err(|_| nothing)?;
        let found = |column: usize| {
            used.iter()
                .position(|&c| c == column)
                .map_or(0.0, |j| solution[j] / scale[j])
        };
        let gain = if joint == 0 {
            believed
        } else {
            turn / found(5)
        };
        if !(gain > 50.0 && gain < 20_000.0) {
            return Err(NoStart { gain, ..nothing });
        }
        let mut set = |quantity: Quantity, value: f64, least: f64, most: f64| {
            at[quantity.at(joint)] = quantity.coordinate(value.clamp(least, most));
        };
        set(Quantity::Inertia, found(0), 2e-3, 0.5);
        set(Quantity::Viscous, found(1), 0.01, 5.0);
        set(Quantity::Coulomb, found(2), 3e-3, 0.5);
        if joint == 0 {
            set(Quantity::Gravity, found(3), 0.02, 5.0);
        }
        set(Quantity::Gain, gain, 100.0, 10_000.0);
        set(Quantity::Offset, found(6) * gain * turn, -100.0, 100.0);
        // The zero is off by what gravity gives at the middle.
        let gravity = if joint == 0 {
            found(3) + Quantity::Gravity.value(mean[Quantity::Gravity.at(1)])
        } else {
            Quantity::Gravity.value(mean[Quantity::Gravity.at(1)])
        };
        let off_rad = found(4) / gravity.max(0.02);
        let zero = Quantity::Zero.value(mean[Quantity::Zero.at(joint)]);
        set(
            Quantity::Zero,
            zero - off_rad / known.rad_per_count[joint],
            zero - 60.0,
            zero + 60.0,
        );
    }
    Ok(at)
}
