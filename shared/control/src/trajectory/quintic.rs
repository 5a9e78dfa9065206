//! Fifth-degree polynomials in time, one per joint: the building block.
//!
//! A quintic meets any angle, speed and acceleration at both ends, and of all
//! motions that do it has the least integral of squared jerk. From rest to rest
//! over D in time T it is
//!
//! ```text
//! q = D (10 u^3 - 15 u^4 + 6 u^5), u = t/T      peak speed         15/8 D/T
//!                                               peak acceleration  10/sqrt(3) D/T^2
//! ```

use super::bounds::{Bounds, Peak, PeakTracker, Quantity, SLACK};
use crate::check_word::checked;
use crate::real::Real;
use crate::trajectory::Reference;
use armbridge_servo::JOINTS;
use heapless::Vec;
use nalgebra::Vector2;

/// Coefficients of a polynomial of one joint, by power of time in s.
type Coefficients<T> = [T; 6];

/// `q(t) = c0 + c1 t + ... + c5 t^5` for both joints, t in s.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Quintic<T> {
    c: [Vector2<T>; 6],
}

checked!(Quintic<T> { c });

impl<T: Real> Quintic<T> {
    /// Rest.
    pub(super) fn resting(q: Vector2<T>) -> Self {
        let mut c = [Vector2::zeros(); 6];
        c[0] = q;
        Self { c }
    }

    /// From one reference at t = 0 to another at `duration_s`.
    pub(super) fn joining(from: &Reference<T>, to: &Reference<T>, duration_s: T) -> Self {
        let lit = T::lit;
        let h = duration_s;
        let inverse = T::one() / h;
        let half_inverse_3 = lit(0.5) * inverse * inverse * inverse;
        // All in rad: differences, and slopes over the whole duration.
        let d = to.q - from.q;
        let (v0, v1) = (from.dq * h, to.dq * h);
        let (a0, a1) = (from.ddq * (h * h), to.ddq * (h * h));
        let c3 = d * lit(20.0) - v1 * lit(8.0) - v0 * lit(12.0) - a0 * lit(3.0) + a1;
        let c4 = v1 * lit(14.0) + v0 * lit(16.0) - d * lit(30.0) + a0 * lit(3.0) - a1 * lit(2.0);
        let c5 = d * lit(12.0) - (v1 + v0) * lit(6.0) + a1 - a0;
        Self {
            c: [
                from.q,
                from.dq,
                from.ddq * lit(0.5),
                c3 * half_inverse_3,
                c4 * (half_inverse_3 * inverse),
                c5 * (half_inverse_3 * inverse * inverse),
            ],
        }
    }

    /// The reference at a time since the start, within the duration.
    pub(super) fn at(&self, t_s: T) -> Reference<T> {
        let [c0, c1, c2, c3, c4, c5] = self.c;
        // Horner for the value, and for its derivatives along with it.
        let q = c5 * t_s + c4;
        let dq = c5 * t_s + q;
        let ddq = c5 * t_s + dq;
        let q = q * t_s + c3;
        let dq = dq * t_s + q;
        let ddq = ddq * t_s + dq;
        let q = q * t_s + c2;
        let dq = dq * t_s + q;
        let ddq = ddq * t_s + dq;
        let q = q * t_s + c1;
        let dq = dq * t_s + q;
        Reference {
            q: q * t_s + c0,
            dq,
            ddq: ddq + ddq,
        }
    }

    /// Shows `tightest` the extremes of every joint and quantity on
    /// 0..=`duration_s`; times count from `starts_s`.
    ///
    /// Exact, not sampled: between two neighbouring zeros of its derivative a
    /// polynomial is monotone, so its own zeros there are found by bisection.
    /// That leads from the fourth derivative, a straight line, up to the angle.
    pub(super) fn show(&self, starts_s: T, duration_s: T, tightest: &mut PeakTracker<T>) {
        for joint in 0..JOINTS {
            let mut derivatives = [[T::zero(); 6]; 5];
            let mut last = self.c.map(|c| c[joint]);
            for derivative in &mut derivatives {
                *derivative = last;
                last = differentiated(&last);
            }
            let mut knots: Vec<T, 8> = Vec::from_iter([T::zero(), duration_s]);
            let next = derivatives.iter().skip(1);
            for (order, (this, next)) in derivatives.iter().zip(next).enumerate().rev() {
                knots = stationary(next, &knots);
                let quantity = match order {
                    0 => Quantity::Angle,
                    1 => Quantity::Speed,
                    2 => Quantity::Acceleration,
                    _ => continue,
                };
                for &t_s in &knots {
                    let value = value(this, t_s);
                    tightest.see(joint, quantity, value, starts_s + t_s);
                }
            }
        }
    }
}

/// One joint of a quintic, over its duration.
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
struct Axis<T> {
    angle: Coefficients<T>,
    duration_s: T,
}

impl<T: Real> Quintic<T> {
    /// Checks a quintic over its duration against the bounds, and against that of jerk if
    /// `with_jerk`; cheaper than to [show](Self::show) it.
    ///
    /// Jerk and acceleration have their extremes where a line and a parabola vanish. Speed
    /// and angle are inside the hull of their Bernstein coefficients; only where this is
    /// not within the bound, bisection finds their extremes.
    ///
    /// # Errors
    ///
    /// The first excess found: of acceleration, then speed, angle and jerk.
    pub(super) fn check(
        &self,
        duration_s: T,
        bounds: &Bounds<T>,
        with_jerk: bool,
    ) -> Result<(), Peak<T>> {
        for joint in 0..JOINTS {
            let axis = Axis {
                angle: self.c.map(|c| c[joint]),
                duration_s,
            };
            axis.check(joint, bounds, with_jerk)?;
        }
        Ok(())
    }
}

impl<T: Real> Axis<T> {
    fn check(&self, joint: usize, bounds: &Bounds<T>, with_jerk: bool) -> Result<(), Peak<T>> {
        let speed = differentiated(&self.angle);
        let acceleration = differentiated(&speed);
        let jerk = differentiated(&acceleration);
        let snap = differentiated(&jerk);
        let verify = |quantity, c: &Coefficients<T>, knots: &[T]| {
            let limit = bounds.of(quantity);
            for &at_s in knots {
                let value = value(c, at_s);
                // What is not a number is beyond every bound.
                let is_within = value.abs() <= limit * T::lit(1.0 + SLACK);
                if !is_within {
                    return Err(Peak {
                        joint,
                        quantity,
                        value,
                        limit,
                        at_s,
                    });
                }
            }
            Ok(())
        };
        let steep = self.knots(quadratic_roots(&jerk));
        verify(Quantity::Acceleration, &acceleration, &steep)?;
        let (is_angle_within, is_speed_within) = self.is_hull_within(bounds);
        if !(is_angle_within && is_speed_within) {
            let fast = stationary(&acceleration, &steep);
            verify(Quantity::Speed, &speed, &fast)?;
            verify(Quantity::Angle, &self.angle, &stationary(&speed, &fast))?;
        }
        if with_jerk {
            let [c0, c1, ..] = snap;
            let root = self.knots([-c0 / c1, T::zero()]);
            verify(Quantity::Jerk, &jerk, &root)?;
        }
        Ok(())
    }

    /// Both ends, and those of the roots that lie between them, in order.
    fn knots(&self, roots: [T; 2]) -> Vec<T, 8> {
        let [a, b] = roots;
        let (first, second) = if a < b { (a, b) } else { (b, a) };
        let mut knots = Vec::new();
        for t in [T::zero(), first, second, self.duration_s] {
            // What is not a number is not inside.
            let is_end = t == T::zero() || t == self.duration_s;
            if is_end || (t > T::zero() && t < self.duration_s) {
                // Four at most.
                let _ = knots.push(t);
            }
        }
        knots
    }

    /// Whether the hulls of angle and speed are within their bounds.
    fn is_hull_within(&self, bounds: &Bounds<T>) -> (bool, bool) {
        let lit = T::lit;
        let h = self.duration_s;
        let mut scale = T::one();
        let [b0, b1, b2, b3, b4, b5] = self.angle.map(|c| {
            let scaled = c * scale;
            scale *= h;
            scaled
        });
        let hull = [
            b0,
            b0 + b1 * lit(0.2),
            b0 + b1 * lit(0.4) + b2 * lit(0.1),
            b0 + b1 * lit(0.6) + b2 * lit(0.3) + b3 * lit(0.1),
            b0 + b1 * lit(0.8) + b2 * lit(0.6) + (b3 + b3 + b4) * lit(0.2),
            b0 + b1 + b2 + b3 + b4 + b5,
        ];
        let step = bounds.speed_rad_s * h * lit(0.2);
        let mut steps = hull.iter().zip(hull.iter().skip(1));
        (
            hull.iter().all(|q| q.abs() <= bounds.angle_rad),
            steps.all(|(from, to)| (*to - *from).abs() <= step),
        )
    }
}

/// Where `c0 + c1 t + c2 t^2` vanishes, without cancellation; what is no number is no root.
fn quadratic_roots<T: Real>(c: &Coefficients<T>) -> [T; 2] {
    let [c0, c1, c2, ..] = *c;
    let square = c1 * c1 - c2 * c0 * T::lit(4.0);
    // Less than zero: the root is no number.
    let q = (c1 + square.sqrt().copysign(c1)) * T::lit(-0.5);
    [q / c2, c0 / q]
}

fn differentiated<T: Real>(c: &Coefficients<T>) -> Coefficients<T> {
    let [_, c1, c2, c3, c4, c5] = *c;
    [
        c1,
        c2 * T::lit(2.0),
        c3 * T::lit(3.0),
        c4 * T::lit(4.0),
        c5 * T::lit(5.0),
        T::zero(),
    ]
}

fn value<T: Real>(c: &Coefficients<T>, t: T) -> T {
    c.iter().rev().fold(T::zero(), |sum, &c| sum * t + c)
}

/// Both outer knots, and between them the zeros of `slope`, which is monotone
/// from knot to knot.
fn stationary<T: Real>(slope: &Coefficients<T>, knots: &[T]) -> Vec<T, 8> {
    let mut found = Vec::new();
    // A polynomial of degree 4 has four zeros at most: six knots, and room.
    let mut keep = |t| {
        let _ = found.push(t);
    };
    knots.first().copied().into_iter().for_each(&mut keep);
    for pair in knots.windows(2) {
        let &[low, high] = pair else { continue };
        let (at_low, at_high) = (value(slope, low), value(slope, high));
        if (at_low < T::zero()) != (at_high < T::zero()) {
            keep(bisected(slope, low, high, at_low < T::zero()));
        }
    }
    knots.last().copied().into_iter().for_each(&mut keep);
    found
}

fn bisected<T: Real>(c: &Coefficients<T>, mut low: T, mut high: T, rises: bool) -> T {
    /// More than an `f64` has digits.
    const HALVINGS: u8 = 60;
    for _ in 0..HALVINGS {
        let middle = (low + high) * T::lit(0.5);
        if middle <= low || middle >= high {
            break;
        }
        if (value(c, middle) < T::zero()) == rises {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low + high) * T::lit(0.5)
}
