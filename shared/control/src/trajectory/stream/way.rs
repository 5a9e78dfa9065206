//! Path segments of a stream: from knot to knot, and from the last to rest.

use super::super::bounds::{Bounds, Peak, Quantity};
use super::super::quintic::Quintic;
use crate::check_word::checked;
use crate::real::Real;
use crate::trajectory::Reference;
use nalgebra::Vector2;

/// Reference angles, and optionally speeds, at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct Point<T> {
    /// Of the board's clock.
    pub at_us: u64,
    /// In rad.
    pub q: Vector2<T>,
    /// In rad/s; `None` to have them computed from the neighbours.
    pub dq: Option<Vector2<T>>,
}

/// A point with the speed and acceleration at which it is passed.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Knot<T> {
    pub(super) at_us: u64,
    pub(super) reference: Reference<T>,
    /// Whether the host sent its speed.
    pub(super) has_speed: bool,
}

/// A quintic from one time of the board's clock to another.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Way<T> {
    quintic: Quintic<T>,
    pub(super) starts_us: u64,
    /// `u64::MAX` for rest, which does not end.
    pub(super) ends_us: u64,
}

checked!(Knot<T> { at_us, reference, has_speed });
checked!(Way<T> { quintic, starts_us, ends_us });

impl<T: Real> Knot<T> {
    /// The same knot on the parabola through its two neighbours: its acceleration, and its
    /// speed unless the host sent that. The first of a stream has the slope to the next.
    pub(super) fn smoothed(&self, before: Option<&Self>, after: &Point<T>) -> Self {
        let q = self.reference.q;
        let after_s = seconds::<T>(after.at_us.saturating_sub(self.at_us));
        let slope_after = (after.q - q) / after_s;
        let (slope, ddq) = match before {
            None => (slope_after, Vector2::zeros()),
            Some(before) => {
                let before_s = seconds::<T>(self.at_us.saturating_sub(before.at_us));
                let slope = (q - before.reference.q) / before_s;
                let both_s = before_s + after_s;
                (
                    (slope * after_s + slope_after * before_s) / both_s,
                    (slope_after - slope) * (T::lit(2.0) / both_s),
                )
            }
        };
        let dq = if self.has_speed {
            self.reference.dq
        } else {
            slope
        };
        Self {
            reference: Reference { q, dq, ddq },
            ..*self
        }
    }

    /// A knot at a point that has no successor yet, in the order of preference: approached
    /// without acceleration, and to rest unless the host sent a speed; or passed, with the
    /// acceleration of the way there.
    pub(super) fn last(point: &Point<T>, before: &Self) -> [Self; 2] {
        let way_s = seconds::<T>(point.at_us.saturating_sub(before.at_us));
        let from = &before.reference;
        let knot = |dq, ddq| Self {
            at_us: point.at_us,
            reference: Reference {
                q: point.q,
                dq,
                ddq,
            },
            has_speed: point.dq.is_some(),
        };
        let even = (point.q - from.q) * (T::lit(2.0) / way_s) - from.dq;
        let dq = point.dq.unwrap_or(even);
        let ddq = (dq - from.dq) / way_s;
        [
            knot(point.dq.unwrap_or_else(Vector2::zeros), Vector2::zeros()),
            knot(dq, ddq),
        ]
    }
}

impl<T: Real> Way<T> {
    pub(super) fn resting(q: Vector2<T>, starts_us: u64) -> Self {
        Self {
            quintic: Quintic::resting(q),
            starts_us,
            ends_us: u64::MAX,
        }
    }

    pub(super) fn between(from: &Knot<T>, to: &Knot<T>) -> Self {
        let way_s = seconds(to.at_us.saturating_sub(from.at_us));
        Self {
            quintic: Quintic::joining(&from.reference, &to.reference, way_s),
            starts_us: from.at_us,
            ends_us: to.at_us,
        }
    }

    /// To rest, as soon as the bounds allow; and whether it ends within that on angles, or
    /// the excess: it ends at the bound then, by braking harder.
    ///
    /// The speed falls as a cubic over the time T. Its slope peaks at `3/2 dq/T` beside what
    /// is left of the acceleration, half the bound here: with an acceleration within the
    /// bound to begin with, the whole stays within. The jerk peaks at the start,
    /// `6 dq/T^2 + 4 ddq/T` at most.
    pub(super) fn braking(from: &Knot<T>, bounds: &Bounds<T>) -> (Self, Result<(), Peak<T>>) {
        /// Longer than any sensible speed and bound take, in s.
        const LONGEST_S: f64 = 10.0;

        let lit = T::lit;
        let Reference { q, dq, ddq } = from.reference;
        let (speed, acceleration) = (dq.amax(), ddq.amax());
        let jerk = bounds.jerk_rad_s3;
        let root = (acceleration * acceleration * lit(4.0) + speed * jerk * lit(6.0)).sqrt();
        let gentle_s = (acceleration * lit(2.0) + root) / jerk;
        let slow_s = speed * lit(3.0) / bounds.acceleration_rad_s2;
        let wanted_s = slow_s.max(gentle_s).min(lit(LONGEST_S));
        // In whole ms, rounded up.
        let brake_us = 1_000 * (u64::from((wanted_s * lit(1e3)).to_count()) + 1);
        let brake_s = seconds::<T>(brake_us);
        let stop = q + dq * (brake_s * lit(0.5)) + ddq * (brake_s * brake_s * lit(1.0 / 12.0));
        let limit = bounds.angle_rad;
        let excess = stop.iter().position(|q| q.abs() > limit);
        let excess = excess.map(|joint| Peak {
            joint,
            quantity: Quantity::Angle,
            value: stop[joint],
            limit,
            at_s: brake_s,
        });
        let rest = Self::between(
            from,
            &Knot {
                at_us: from.at_us.saturating_add(brake_us),
                reference: Reference::at_rest(stop.map(|q| q.min(limit).max(-limit))),
                has_speed: true,
            },
        );
        (rest, excess.map_or(Ok(()), Err))
    }

    /// The reference at a time since it began; from its end on, that of its end.
    pub(super) fn at(&self, now_us: u64) -> Reference<T> {
        let until_us = now_us.min(self.ends_us);
        self.quintic
            .at(seconds(until_us.saturating_sub(self.starts_us)))
    }

    /// Checks it against the bounds, and against that of jerk if `with_jerk`.
    pub(super) fn check(&self, bounds: &Bounds<T>, with_jerk: bool) -> Result<(), Peak<T>> {
        let way_s = seconds(self.ends_us.saturating_sub(self.starts_us));
        self.quintic.check(way_s, bounds, with_jerk)
    }

    /// Flips a bit of the start time, for tests of error detection.
    pub(super) fn inject_error(&mut self, bit: u32) {
        self.starts_us ^= 1 << bit;
    }
}

/// Microseconds in s, without the `f64` that a Cortex-M4F lacks. Saturates after
/// 71 minutes.
fn seconds<T: Real>(us: u64) -> T {
    let us = u32::try_from(us).unwrap_or(u32::MAX);
    let [high, low] = [us >> 16, us & 0xFFFF].map(|half| T::from_count(half as u16));
    (high * T::lit(65536.0) + low) * T::lit(1e-6)
}
