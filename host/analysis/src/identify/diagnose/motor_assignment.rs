//! Motor assignment: which motor drives a joint, and in which direction, before any fit.
//!
//! Over segments in which a joint slides, its acceleration is regressed on the terms of any
//! arm (friction in either direction, gravity) and on the PWM of one motor or of the other.
//! The motor that explains more drives the joint.

use armbridge_servo::JOINTS;
use nalgebra::{DMatrix, DVector};

use super::super::arm::KnownParameters;
use super::super::dataset::Trace;
use super::Diagnosis;
use super::bump::Bump;

/// Half the length of a segment, and distance between segments, in ticks.
const HALF: usize = 80;
const STRIDE: usize = 40;
/// Speed in rad/s above which a joint counts as sliding.
const SLIDES_RAD_S: f64 = 0.17;
/// Assumed delay in ticks.
const DELAY_TICKS: i64 = 3;
/// Fewest segments for a diagnosis.
const SEGMENTS_MIN: usize = 30;
/// Standard deviation of a segment's acceleration with noise of a count, in rad/s².
const NOISE_RAD_S2: f64 = 1.2;
/// Standard errors by which the sign of a motor's gain is significant.
const SIGMAS: f64 = 8.0;
/// Number of columns without a motor: a constant, speed, its sign, gravity.
const ARM_TERMS: usize = 4;

/// A segment: the terms of any arm, the mean PWM of both motors in counts from neutral, and
/// the acceleration in rad/s².
type Row = ([f64; ARM_TERMS], [f64; JOINTS], f64);

/// Checks that each joint is driven by its own motor, in the right direction; traces are
/// smoothed.
///
/// # Errors
/// If a joint is driven by the other's motor, in the wrong direction, or by none.
pub(super) fn check(traces: &[Trace], known: &KnownParameters) -> Result<(), Diagnosis> {
    let bump = Bump::new(HALF);
    for joint in 0..known.joints {
        let rows: Vec<Row> = traces
            .iter()
            .flat_map(|trace| segments(trace, known, joint, &bump))
            .collect();
        if rows.len() < SEGMENTS_MIN {
            continue;
        }
        let other = 1 - joint;
        let without_motor = regress(&rows, None).residual_squares;
        let [own_motor, other_motor] = [joint, other].map(|motor| regress(&rows, Some(motor)));
        let [by_own, by_other] =
            [&own_motor, &other_motor].map(|fit| 1.0 - fit.residual_squares / without_motor);
        if by_other > 0.5 && other_motor.residual_squares < 0.5 * own_motor.residual_squares {
            return Err(Diagnosis::WrongJoint {
                joint: joint + 1,
                other: other + 1,
                by_other: 100.0 * by_other,
                by_own: 100.0 * by_own,
            });
        }
        let gain = own_motor.gain * known.rad_per_count[joint].signum();
        if gain < -SIGMAS * own_motor.error && by_own > 0.1 {
            return Err(Diagnosis::WrongDirection {
                joint: joint + 1,
                rad_s2: 100.0 * gain,
            });
        }
        let acceleration = (without_motor / rows.len() as f64).sqrt();
        if gain < SIGMAS * own_motor.error && by_own < 0.1 && acceleration > 3.0 * NOISE_RAD_S2 {
            return Err(Diagnosis::NotDriven { joint: joint + 1 });
        }
    }
    Ok(())
}

/// Segments of a trace in which a joint slides one way.
fn segments<'a>(
    trace: &'a Trace,
    known: &'a KnownParameters,
    joint: usize,
    bump: &'a Bump,
) -> impl Iterator<Item = Row> + 'a {
    let speed = move |tick: usize| trace.states[tick][joint][1];
    let firsts = (0..trace.states.len().saturating_sub(bump.len())).step_by(STRIDE);
    let slides = move |first: &usize| {
        let direction = speed(*first).signum();
        (*first..first + bump.len()).all(|tick| speed(tick) * direction > SLIDES_RAD_S)
    };
    firsts.filter(slides).map(move |first| {
        let pwm = [0, 1].map(|motor| {
            bump.mean(first, |tick| {
                f64::from(trace.pwm_at(tick as i64 - DELAY_TICKS, motor)) - 1_000.0
            })
        });
        let gravity = bump.mean(first, |tick| {
            let [q, other] = [joint, 1 - joint].map(|j| trace.states[tick][j][0]);
            q.sin() * if joint == 0 { 1.0 } else { other.cos() }
        });
        let v = bump.mean(first, speed);
        let acceleration = bump.rate(first, speed) / known.period_s;
        ([1.0, v, v.signum(), gravity], pwm, acceleration)
    })
}

/// Regression of the segments' accelerations.
struct Regression {
    /// Residual sum of squares.
    residual_squares: f64,
    /// Acceleration per PWM count, and its standard error.
    gain: f64,
    error: f64,
}

fn regress(rows: &[Row], motor: Option<usize>) -> Regression {
    let columns = ARM_TERMS + usize::from(motor.is_some());
    let matrix = DMatrix::from_fn(rows.len(), columns, |i, j| match motor {
        Some(motor) if j == ARM_TERMS => rows[i].1[motor],
        Some(_) | None => rows[i].0[j],
    });
    let right = DVector::from_fn(rows.len(), |i, _| rows[i].2);
    let nothing = Regression {
        residual_squares: right.norm_squared(),
        gain: 0.0,
        error: f64::INFINITY,
    };
    let svd = matrix.clone().svd(true, true);
    let (Ok(solution), Ok(inverse)) = (svd.solve(&right, 1e-12), svd.pseudo_inverse(1e-12)) else {
        return nothing;
    };
    let residual_squares = (right - matrix * &solution).norm_squared();
    let variance = residual_squares / rows.len().saturating_sub(columns).max(1) as f64;
    if motor.is_none() {
        return Regression {
            residual_squares,
            ..nothing
        };
    }
    Regression {
        residual_squares,
        gain: solution[ARM_TERMS],
        error: inverse.row(ARM_TERMS).norm() * variance.sqrt(),
    }
}
