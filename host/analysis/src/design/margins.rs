//! How much can be wrong with the torque before the loop is unstable.
//!
//! The loop is broken where the torque acts, L being what comes back (2 x 2, at
//! `z = exp(i w T)`, w up to half the sampling frequency). The estimator is
//! given the torque that was asked for, without the error.
//!
//! * **gain**: factors on a joint's torque, the other joint's being right, between which
//!   the loop is stable, found by its eigenvalues. An arm that falls by itself has a lower
//!   one, too.
//! * **phase**: the smallest turn of `L` that makes it -1 where its magnitude is 1.
//! * **delay**: how much later than planned the torque may act. Exact: the torque then
//!   changes within the period, which is more than a turn.
//! * **disc**: both joints at once, in gain and phase: `alpha = 1 / max |S - 1/2|`, with
//!   `S = (1 + L)^-1` and the largest singular value over all frequencies. Any factors
//!   within `(2 - alpha)/(2 + alpha)` and its inverse, or turns to `2 atan(alpha/2)`, one
//!   for each joint, leave the loop stable (Seiler, Packard, Gahinet: An introduction to
//!   disk margins, 2020).
//! * **sensitivity**: the largest singular value of S: what becomes of a disturbance at
//!   its worst frequency. 1/it is how near L comes to -1.

use core::f64::consts::{PI, TAU};

use armbridge_shared::JOINTS;
use nalgebra::{Complex, Matrix2, SMatrix};
use serde::Serialize;

use super::model::{Input, Loop, STATES, radius};

type Response = Matrix2<Complex<f64>>;

/// Lowest frequency looked at, in rad/s: far below any of the arm.
const LOWEST_RAD_S: f64 = 0.05;
/// Frequencies looked at, evenly on a logarithmic scale.
const FREQUENCIES: usize = 1_500;
/// Largest factor that is looked for.
const MOST_GAIN: f64 = 1e3;

/// What can be wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// With each joint alone.
    pub joints: [JointMargins; JOINTS],
    /// Factors on both torques together between which the loop is stable.
    pub both_gain: [Option<f64>; 2],
    /// With both at once, independently.
    pub disc: Disc,
    /// Largest singular value of the sensitivity at the torque, and where.
    pub sensitivity: f64,
    /// In rad/s.
    pub sensitivity_rad_s: f64,
}

/// What can be wrong with one joint's torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointMargins {
    /// Factors between which the loop is stable; `None` where there is no end, at 0.001 or
    /// 1000.
    pub gain: [Option<f64>; 2],
    /// Where the phase matters most.
    pub phase: Option<Crossing>,
    /// Additional delay in s at which the loop is on the edge.
    pub delay_s: Option<f64>,
}

/// A frequency at which what comes back is as large as what was sent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crossing {
    /// In rad/s.
    pub at_rad_s: f64,
    /// Turn to the edge, in degrees.
    pub margin_deg: f64,
}

/// The symmetric disc margin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Disc {
    /// Its size: 0 is no margin, 2 the most that there is.
    pub alpha: f64,
    /// Factors on both torques, each its own, that it allows.
    pub gain: [f64; 2],
    /// Turn of both, each its own, that it allows, in degrees.
    pub phase_deg: f64,
    /// The worst frequency in rad/s.
    pub at_rad_s: f64,
}

impl Margins {
    pub(super) fn of(parts: &Loop) -> Self {
        let half = Matrix2::identity() * Complex::new(0.5, 0.0);
        let (sensitivity_rad_s, sensitivity) = peak(parts, |l| largest(&shrinking(l)));
        let (at_rad_s, size) = peak(parts, |l| largest(&(shrinking(l) - half)));
        let alpha = (1.0 / size).min(2.0);
        let most = (2.0 + alpha) / (2.0 - alpha);
        Self {
            joints: [0, 1].map(|joint| joint_margins(parts, joint)),
            both_gain: gain_range(parts, |gain| [gain; JOINTS]),
            disc: Disc {
                alpha,
                gain: [1.0 / most, most],
                phase_deg: 2.0 * (alpha / 2.0).atan().to_degrees(),
                at_rad_s,
            },
            sensitivity,
            sensitivity_rad_s,
        }
    }
}

fn joint_margins(parts: &Loop, joint: usize) -> JointMargins {
    let crossings = crossings(parts, joint);
    let turn = |(w, back): &(f64, Complex<f64>)| {
        // Of L to -1, clockwise, as a delay turns.
        (*w, (back.im.atan2(back.re) + PI).rem_euclid(TAU))
    };
    let turns: Vec<(f64, f64)> = crossings.iter().map(turn).collect();
    let phase = turns
        .iter()
        .map(|(w, lag)| Crossing {
            at_rad_s: *w,
            margin_deg: lag.min(TAU - lag).to_degrees(),
        })
        .min_by(|a, b| a.margin_deg.total_cmp(&b.margin_deg));
    let delay_s = turns
        .iter()
        .map(|(w, lag)| edge_delay_s(parts, joint, *w, lag / w))
        .min_by(f64::total_cmp);
    JointMargins {
        gain: gain_range(parts, |gain| {
            let mut scale = [1.0; JOINTS];
            scale[joint] = gain;
            scale
        }),
        phase,
        delay_s,
    }
}

/// The first factors below and above 1 with which the loop does not decay.
fn gain_range(parts: &Loop, scale: impl Fn(f64) -> [f64; JOINTS]) -> [Option<f64>; 2] {
    let grows = |gain: f64| radius(&parts.with_torque_scaled(scale(gain))) >= 1.0;
    let edge = |factor: f64| {
        let mut stable = 1.0;
        if grows(stable) {
            return Some(stable);
        }
        while (1.0 / MOST_GAIN..=MOST_GAIN).contains(&stable) {
            let next = stable * factor;
            if grows(next) {
                let (mut inside, mut outside) = (stable, next);
                for _ in 0..50 {
                    let middle = f64::midpoint(inside, outside);
                    if grows(middle) {
                        outside = middle;
                    } else {
                        inside = middle;
                    }
                }
                return Some(inside);
            }
            stable = next;
        }
        None
    };
    [edge(1.0 / 1.03), edge(1.03)]
}

/// What comes back of a torque at this frequency.
fn response(parts: &Loop, w: f64, input: &SMatrix<Complex<f64>, STATES, JOINTS>) -> Response {
    let (sin, cos) = (w * parts.period_s).sin_cos();
    let z = Complex::new(cos, sin);
    let open = parts.open.map(|x| Complex::new(-x, 0.0));
    let moved = open + SMatrix::identity() * z;
    let output = parts.output.map(|x| Complex::new(x, 0.0));
    moved.lu().solve(input).map_or_else(
        // At a pole of the broken loop everything comes back.
        || Matrix2::identity() * Complex::new(1e12, 0.0),
        |states| output * states,
    )
}

fn complex(input: &Input) -> SMatrix<Complex<f64>, STATES, JOINTS> {
    input.map(|x| Complex::new(x, 0.0))
}

/// What comes back of one joint's torque, the other's loop being closed.
fn of_joint(l: &Response, joint: usize) -> Complex<f64> {
    let other = 1 - joint;
    let around = l[(joint, other)] * l[(other, joint)];
    l[(joint, joint)] - around / (Complex::new(1.0, 0.0) + l[(other, other)])
}

fn frequencies(parts: &Loop) -> impl Iterator<Item = f64> {
    let highest = PI / parts.period_s;
    let growth = (highest / LOWEST_RAD_S).ln() / (FREQUENCIES - 1) as f64;
    // An arm that falls by itself is often worst off at rest.
    let grid = (0..FREQUENCIES).map(move |i| LOWEST_RAD_S * (growth * i as f64).exp());
    core::iter::once(0.0).chain(grid)
}

/// Where as much comes back as was sent, and what.
fn crossings(parts: &Loop, joint: usize) -> Vec<(f64, Complex<f64>)> {
    let input = complex(&parts.input);
    let back = |w: f64| of_joint(&response(parts, w, &input), joint);
    let excess = |w: f64| back(w).norm_sqr() - 1.0;
    let all: Vec<(f64, f64)> = frequencies(parts).map(|w| (w, excess(w))).collect();
    let pairs = all.windows(2).filter_map(|pair| match pair {
        [(low, at_low), (high, at_high)] if (*at_low > 0.0) != (*at_high > 0.0) => {
            Some((*low, *high, *at_low > 0.0))
        }
        _ => None,
    });
    pairs
        .map(|(mut low, mut high, falls)| {
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if (excess(middle) > 0.0) == falls {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            (low, back(low))
        })
        .collect()
}

/// The largest of a quantity over frequency, and where.
fn peak(parts: &Loop, quantity: impl Fn(&Response) -> f64) -> (f64, f64) {
    let input = complex(&parts.input);
    let at = |w: f64| quantity(&response(parts, w, &input));
    let all: Vec<(f64, f64)> = frequencies(parts).map(|w| (w, at(w))).collect();
    let best = (0..all.len()).max_by(|a, b| all[*a].1.total_cmp(&all[*b].1));
    let best = best.unwrap_or_default();
    let (mut low, mut high) = (
        all[best.saturating_sub(1)].0,
        all[(best + 1).min(all.len() - 1)].0,
    );
    // A peak between two neighbours, closed in on by thirds.
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if at(low + third) < at(high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    let w = f64::midpoint(low, high);
    let found = (w, at(w));
    if found.1 >= all[best].1 {
        found
    } else {
        all[best]
    }
}

fn shrinking(l: &Response) -> Response {
    let back = l + Matrix2::identity();
    // Singular only where the loop is on the edge.
    back.try_inverse()
        .unwrap_or_else(|| Matrix2::identity() * Complex::new(1e12, 0.0))
}

/// The largest singular value.
fn largest(m: &Response) -> f64 {
    // From trace and determinant of M* M, which is Hermitian.
    let squares = m.iter().map(Complex::norm_sqr).sum::<f64>();
    let determinant = (m.m11 * m.m22 - m.m12 * m.m21).norm_sqr();
    let spread = (squares * squares - 4.0 * determinant).max(0.0).sqrt();
    f64::midpoint(squares, spread).sqrt()
}

/// The delay of a joint's torque with which the loop is on the edge, near this one; both
/// are found together with the frequency, by Newton's method.
fn edge_delay_s(parts: &Loop, joint: usize, near_rad_s: f64, near_s: f64) -> f64 {
    let one = Complex::new(1.0, 0.0);
    let short = |w: f64, delay_s: f64| {
        let input = delayed(parts, joint, w, delay_s);
        one + of_joint(&response(parts, w, &input), joint)
    };
    let (mut w, mut delay_s) = (near_rad_s, near_s);
    for _ in 0..30 {
        let here = short(w, delay_s);
        let (dw, dt) = (w * 1e-6, near_s.max(1e-6) * 1e-6);
        let by_w = (short(w + dw, delay_s) - here) / dw;
        let by_t = (short(w, delay_s + dt) - here) / dt;
        let jacobian = Matrix2::new(by_w.re, by_t.re, by_w.im, by_t.im);
        let Some(inverse) = jacobian.try_inverse() else {
            break;
        };
        let step = inverse * nalgebra::Vector2::new(here.re, here.im);
        w -= step.x;
        delay_s -= step.y;
        if !(w > 0.0 && delay_s > 0.0) {
            break;
        }
        if step.y.abs() < 1e-12 {
            return delay_s;
        }
    }
    near_s
}

/// The input matrix at this frequency when one joint's torque acts later.
fn delayed(
    parts: &Loop,
    joint: usize,
    w: f64,
    delay_s: f64,
) -> SMatrix<Complex<f64>, STATES, JOINTS> {
    let period_s = parts.period_s;
    let periods = (delay_s / period_s).floor();
    let late_s = delay_s - periods * period_s;
    // Until then the torque before acts.
    let (before, rest) = (
        parts.arm.zero_order_hold(late_s),
        parts.arm.zero_order_hold(period_s - late_s),
    );
    let turn = |periods: f64| {
        let (sin, cos) = (-w * period_s * periods).sin_cos();
        Complex::new(cos, sin)
    };
    let (present, past) = (rest.b, rest.a * before.b);
    let mut input = complex(&parts.input);
    for state in 0..4 {
        input[(state, joint)] =
            turn(periods) * present[(state, joint)] + turn(periods + 1.0) * past[(state, joint)];
    }
    input
}
