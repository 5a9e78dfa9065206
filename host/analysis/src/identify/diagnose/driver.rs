//! Which motor a joint obeys, and which way, before anything of the arm is known.
//!
//! Over stretches in which a joint slides, its acceleration is explained by what any arm
//! has (friction either way, gravity) and by the PWM of one motor or of the other. The
//! motor that explains more is the one that turns it.

use armbridge_shared::JOINTS;
use nalgebra::{DMatrix, DVector};

use super::super::arm::Known;
use super::super::dataset::Trace;
use super::Diagnosis;
use super::bump::Bump;

/// Half a stretch, and from one to the next, in ticks.
const HALF: usize = 80;
const STRIDE: usize = 40;
/// Speed in rad/s above which a joint surely slides.
const SLIDES_RAD_S: f64 = 0.17;
/// Delay that is assumed, in ticks.
const DELAY_TICKS: i64 = 3;
/// Fewest stretches for a diagnosis.
const FEWEST: usize = 30;
/// Standard deviation of a stretch's acceleration by noise of a count, in rad/s².
const NOISE_RAD_S2: f64 = 1.2;
/// Standard errors by which a motor surely pushes the one way and not the other.
const SURE: f64 = 8.0;
/// Columns without a motor: a constant, speed, its sign, gravity.
const PLAIN: usize = 4;

/// A stretch: what accelerates any arm, the mean PWM of both motors in counts from off,
/// and the acceleration in rad/s².
type Row = ([f64; PLAIN], [f64; JOINTS], f64);

/// Whether each joint obeys its own motor; traces are smoothed.
///
/// # Errors
/// If it obeys the other's, or obeys it backwards, or none.
pub(super) fn check(traces: &[Trace], known: &Known) -> Result<(), Diagnosis> {
    let bump = Bump::new(HALF);
    for joint in 0..JOINTS {
        let rows: Vec<Row> = traces
            .iter()
            .flat_map(|trace| stretches(trace, known, joint, &bump))
            .collect();
        if rows.len() < FEWEST {
            continue;
        }
        let other = 1 - joint;
        let plain = solve(&rows, None).rest;
        let [own, others] = [joint, other].map(|motor| solve(&rows, Some(motor)));
        let [by_own, by_other] = [&own, &others].map(|fit| 1.0 - fit.rest / plain);
        if by_other > 0.5 && others.rest < 0.5 * own.rest {
            return Err(Diagnosis::WrongJoint {
                joint: joint + 1,
                other: other + 1,
                by_other: 100.0 * by_other,
                by_own: 100.0 * by_own,
            });
        }
        let slope = own.slope * known.rad_per_count[joint].signum();
        if slope < -SURE * own.error && by_own > 0.1 {
            return Err(Diagnosis::WrongWay {
                joint: joint + 1,
                rad_s2: 100.0 * slope,
            });
        }
        let moves = (plain / rows.len() as f64).sqrt();
        if slope < SURE * own.error && by_own < 0.1 && moves > 3.0 * NOISE_RAD_S2 {
            return Err(Diagnosis::NotDriven { joint: joint + 1 });
        }
    }
    Ok(())
}

/// The stretches of a trace in which a joint slides one way.
fn stretches<'a>(
    trace: &'a Trace,
    known: &'a Known,
    joint: usize,
    bump: &'a Bump,
) -> impl Iterator<Item = Row> + 'a {
    let speed = move |tick: usize| trace.smooth[tick][joint][1];
    let firsts = (0..trace.smooth.len().saturating_sub(bump.len())).step_by(STRIDE);
    let slides = move |first: &usize| {
        let way = speed(*first).signum();
        (*first..first + bump.len()).all(|tick| speed(tick) * way > SLIDES_RAD_S)
    };
    firsts.filter(slides).map(move |first| {
        let pwm = [0, 1].map(|motor| {
            bump.mean(first, |tick| {
                f64::from(trace.pwm_at(tick as i64 - DELAY_TICKS, motor)) - 1_000.0
            })
        });
        let gravity = bump.mean(first, |tick| {
            let [q, other] = [joint, 1 - joint].map(|j| trace.smooth[tick][j][0]);
            q.sin() * if joint == 0 { 1.0 } else { other.cos() }
        });
        let v = bump.mean(first, speed);
        let acceleration = bump.rate(first, speed) / known.period_s;
        ([1.0, v, v.signum(), gravity], pwm, acceleration)
    })
}

/// How the stretches are explained best.
struct Explained {
    /// Sum of squares that is left.
    rest: f64,
    /// Acceleration for a PWM count, and its standard error.
    slope: f64,
    error: f64,
}

fn solve(rows: &[Row], motor: Option<usize>) -> Explained {
    let columns = PLAIN + usize::from(motor.is_some());
    let matrix = DMatrix::from_fn(rows.len(), columns, |i, j| match motor {
        Some(motor) if j == PLAIN => rows[i].1[motor],
        Some(_) | None => rows[i].0[j],
    });
    let right = DVector::from_fn(rows.len(), |i, _| rows[i].2);
    let nothing = Explained {
        rest: right.norm_squared(),
        slope: 0.0,
        error: f64::INFINITY,
    };
    let svd = matrix.clone().svd(true, true);
    let (Ok(solution), Ok(inverse)) = (svd.solve(&right, 1e-12), svd.pseudo_inverse(1e-12)) else {
        return nothing;
    };
    let rest = (right - matrix * &solution).norm_squared();
    let variance = rest / rows.len().saturating_sub(columns).max(1) as f64;
    if motor.is_none() {
        return Explained { rest, ..nothing };
    }
    Explained {
        rest,
        slope: solution[PLAIN],
        error: inverse.row(PLAIN).norm() * variance.sqrt(),
    }
}
