//! Stability margins of the loop against errors of the torque.
//!
//! The loop is broken at the torque, and L is its loop gain (2 x 2, at
//! `z = exp(i w T)`, w up to half the sampling frequency). The estimator's input is
//! the requested torque, without the error.
//!
//! * **gain**: factors on a joint's torque, the other joint's being correct, between which
//!   the loop is stable, found by its eigenvalues. An arm that is unstable in open loop has
//!   a lower factor, too.
//! * **phase**: the smallest rotation that makes `L` -1 where its magnitude is 1.
//! * **delay**: the additional delay of the torque at which the loop becomes unstable.
//!   Exact: the torque then changes within the period, which is more than a rotation.
//! * **disc**: both joints at once, in gain and phase: `alpha = 1 / max |S - 1/2|`, with
//!   `S = (1 + L)^-1` and the largest singular value over all frequencies. Any factors
//!   within `(2 - alpha)/(2 + alpha)` and its inverse, or rotations up to
//!   `2 atan(alpha/2)`, one for each joint, leave the loop stable (Seiler, Packard, Gahinet: An introduction to
//!   disk margins, 2020).
//! * **sensitivity**: the largest singular value of S over frequency: the amplification of
//!   a disturbance at its worst frequency. Its inverse is the distance of L from -1.

use core::f64::consts::{PI, TAU};

use armbridge_servo::JOINTS;
use nalgebra::{Complex, Matrix2, SMatrix};
use serde::Serialize;

use super::model::{Input, LinearLoop, STATES, spectral_radius};

type Response = Matrix2<Complex<f64>>;

/// Lowest frequency of the grid in rad/s: far below any of the arm.
const LOWEST_RAD_S: f64 = 0.05;
/// Number of frequencies, evenly spaced on a logarithmic scale.
const FREQUENCIES: usize = 1_500;
/// Largest gain factor searched.
const MAX_GAIN: f64 = 1e3;

/// Stability margins.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// Margins of each joint alone.
    pub joints: [JointMargins; JOINTS],
    /// Common factors on both torques between which the loop is stable.
    pub both_gain: [Option<f64>; 2],
    /// Margin of both joints at once, independently.
    pub disc: Disc,
    /// Largest singular value of the sensitivity at the torque.
    pub sensitivity: f64,
    /// Frequency of that value in rad/s.
    pub sensitivity_rad_s: f64,
}

/// Margins of one joint's torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointMargins {
    /// Factors between which the loop is stable; `None` if there is no limit down to 0.001
    /// or up to 1000.
    pub gain: [Option<f64>; 2],
    /// Crossover with the smallest phase margin.
    pub phase: Option<Crossing>,
    /// Additional delay in s at the stability limit.
    pub delay_s: Option<f64>,
}

/// A gain crossover.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crossing {
    /// Frequency in rad/s.
    pub at_rad_s: f64,
    /// Phase margin in degrees.
    pub margin_deg: f64,
}

/// The symmetric disc margin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Disc {
    /// Size: 0 is no margin, 2 the largest possible.
    pub alpha: f64,
    /// Permitted independent factors on both torques.
    pub gain: [f64; 2],
    /// Permitted independent phase changes of both torques, in degrees.
    pub phase_deg: f64,
    /// The worst frequency in rad/s.
    pub at_rad_s: f64,
}

impl Margins {
    pub(super) fn from_loop(system: &LinearLoop) -> Self {
        let half = Matrix2::identity() * Complex::new(0.5, 0.0);
        let (sensitivity_rad_s, sensitivity) =
            peak(system, |l| largest_singular_value(&sensitivity_matrix(l)));
        let (at_rad_s, size) = peak(system, |l| {
            largest_singular_value(&(sensitivity_matrix(l) - half))
        });
        let alpha = (1.0 / size).min(2.0);
        let factor = (2.0 + alpha) / (2.0 - alpha);
        Self {
            joints: [0, 1].map(|joint| joint_margins(system, joint)),
            both_gain: gain_range(system, |gain| [gain; JOINTS]),
            disc: Disc {
                alpha,
                gain: [1.0 / factor, factor],
                phase_deg: 2.0 * (alpha / 2.0).atan().to_degrees(),
                at_rad_s,
            },
            sensitivity,
            sensitivity_rad_s,
        }
    }
}

fn joint_margins(system: &LinearLoop, joint: usize) -> JointMargins {
    let crossings = crossings(system, joint);
    let lag = |(w, gain): &(f64, Complex<f64>)| {
        // Rotation from L to -1, clockwise, like that of a delay.
        (*w, (gain.im.atan2(gain.re) + PI).rem_euclid(TAU))
    };
    let lags: Vec<(f64, f64)> = crossings.iter().map(lag).collect();
    let phase = lags
        .iter()
        .map(|(w, lag)| Crossing {
            at_rad_s: *w,
            margin_deg: lag.min(TAU - lag).to_degrees(),
        })
        .min_by(|a, b| a.margin_deg.total_cmp(&b.margin_deg));
    let delay_s = lags
        .iter()
        .map(|(w, lag)| edge_delay_s(system, joint, *w, lag / w))
        .min_by(f64::total_cmp);
    JointMargins {
        gain: gain_range(system, |gain| {
            let mut scale = [1.0; JOINTS];
            scale[joint] = gain;
            scale
        }),
        phase,
        delay_s,
    }
}

/// The first factors below and above 1 at which the loop becomes unstable.
fn gain_range(system: &LinearLoop, scale: impl Fn(f64) -> [f64; JOINTS]) -> [Option<f64>; 2] {
    let grows = |gain: f64| spectral_radius(&system.with_torque_scaled(scale(gain))) >= 1.0;
    let edge = |factor: f64| {
        let mut stable = 1.0;
        if grows(stable) {
            return Some(stable);
        }
        while (1.0 / MAX_GAIN..=MAX_GAIN).contains(&stable) {
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

/// Loop gain at a frequency in rad/s.
fn response(
    system: &LinearLoop,
    w: f64,
    input: &SMatrix<Complex<f64>, STATES, JOINTS>,
) -> Response {
    let (sin, cos) = (w * system.period_s).sin_cos();
    let z = Complex::new(cos, sin);
    let open = system.open.map(|x| Complex::new(-x, 0.0));
    let resolvent = open + SMatrix::identity() * z;
    let output = system.output.map(|x| Complex::new(x, 0.0));
    resolvent.lu().solve(input).map_or_else(
        // At a pole of the open loop the gain is infinite.
        || Matrix2::identity() * Complex::new(1e12, 0.0),
        |states| output * states,
    )
}

fn complex(input: &Input) -> SMatrix<Complex<f64>, STATES, JOINTS> {
    input.map(|x| Complex::new(x, 0.0))
}

/// Loop gain of one joint with the other joint's loop closed.
fn joint_gain(l: &Response, joint: usize) -> Complex<f64> {
    let other = 1 - joint;
    let coupling = l[(joint, other)] * l[(other, joint)];
    l[(joint, joint)] - coupling / (Complex::new(1.0, 0.0) + l[(other, other)])
}

fn frequencies(system: &LinearLoop) -> impl Iterator<Item = f64> {
    let highest = PI / system.period_s;
    let growth = (highest / LOWEST_RAD_S).ln() / (FREQUENCIES - 1) as f64;
    // The worst frequency of an arm that is unstable in open loop is often 0.
    let grid = (0..FREQUENCIES).map(move |i| LOWEST_RAD_S * (growth * i as f64).exp());
    core::iter::once(0.0).chain(grid)
}

/// Gain crossovers: frequencies in rad/s and loop gains.
fn crossings(system: &LinearLoop, joint: usize) -> Vec<(f64, Complex<f64>)> {
    let input = complex(&system.input);
    let gain = |w: f64| joint_gain(&response(system, w, &input), joint);
    let excess = |w: f64| gain(w).norm_sqr() - 1.0;
    let all: Vec<(f64, f64)> = frequencies(system).map(|w| (w, excess(w))).collect();
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
            (low, gain(low))
        })
        .collect()
}

/// Frequency in rad/s and value of the largest of a quantity over frequency.
fn peak(system: &LinearLoop, quantity: impl Fn(&Response) -> f64) -> (f64, f64) {
    let input = complex(&system.input);
    let value = |w: f64| quantity(&response(system, w, &input));
    let all: Vec<(f64, f64)> = frequencies(system).map(|w| (w, value(w))).collect();
    let best = (0..all.len()).max_by(|a, b| all[*a].1.total_cmp(&all[*b].1));
    let best = best.unwrap_or_default();
    let (mut low, mut high) = (
        all[best.saturating_sub(1)].0,
        all[(best + 1).min(all.len() - 1)].0,
    );
    // Ternary search for the peak between the neighbours.
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if value(low + third) < value(high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    let w = f64::midpoint(low, high);
    let found = (w, value(w));
    if found.1 >= all[best].1 {
        found
    } else {
        all[best]
    }
}

/// `(1 + L)^-1`.
fn sensitivity_matrix(l: &Response) -> Response {
    let difference = l + Matrix2::identity();
    // Singular only at the stability limit.
    difference
        .try_inverse()
        .unwrap_or_else(|| Matrix2::identity() * Complex::new(1e12, 0.0))
}

/// Largest singular value.
fn largest_singular_value(m: &Response) -> f64 {
    // From trace and determinant of M* M, which is Hermitian.
    let squares = m.iter().map(Complex::norm_sqr).sum::<f64>();
    let determinant = (m.m11 * m.m22 - m.m12 * m.m21).norm_sqr();
    let spread = (squares * squares - 4.0 * determinant).max(0.0).sqrt();
    f64::midpoint(squares, spread).sqrt()
}

/// Delay in s of a joint's torque at the stability limit, near `near_s`; Newton's method
/// finds it together with its frequency.
fn edge_delay_s(system: &LinearLoop, joint: usize, near_rad_s: f64, near_s: f64) -> f64 {
    let one = Complex::new(1.0, 0.0);
    let residual = |w: f64, delay_s: f64| {
        let input = delayed(system, joint, w, delay_s);
        one + joint_gain(&response(system, w, &input), joint)
    };
    let (mut w, mut delay_s) = (near_rad_s, near_s);
    for _ in 0..30 {
        let here = residual(w, delay_s);
        let (dw, dt) = (w * 1e-6, near_s.max(1e-6) * 1e-6);
        let by_w = (residual(w + dw, delay_s) - here) / dw;
        let by_t = (residual(w, delay_s + dt) - here) / dt;
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

/// Input matrix at a frequency if one joint's torque is delayed.
fn delayed(
    system: &LinearLoop,
    joint: usize,
    w: f64,
    delay_s: f64,
) -> SMatrix<Complex<f64>, STATES, JOINTS> {
    let period_s = system.period_s;
    let periods = (delay_s / period_s).floor();
    let late_s = delay_s - periods * period_s;
    // Until `late_s` the previous torque acts.
    let (before, rest) = (
        system.arm.zero_order_hold(late_s),
        system.arm.zero_order_hold(period_s - late_s),
    );
    let delay = |periods: f64| {
        let (sin, cos) = (-w * period_s * periods).sin_cos();
        Complex::new(cos, sin)
    };
    let (present, past) = (rest.b, rest.a * before.b);
    let mut input = complex(&system.input);
    for state in 0..4 {
        input[(state, joint)] =
            delay(periods) * present[(state, joint)] + delay(periods + 1.0) * past[(state, joint)];
    }
    input
}
