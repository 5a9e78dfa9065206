//! Envelope of a wave: its ramps at both ends.

use crate::real::Real;

/// An envelope at one time: it rises from 0 to 1 and falls back by the quintic of
/// least jerk, `10 u^3 - 15 u^4 + 6 u^5`, both in the time of the ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Envelope<T> {
    /// From 0 to 1.
    pub(crate) e: T,
    /// Its derivative in 1/s.
    pub(crate) de: T,
    /// The second, in 1/s^2.
    pub(crate) dde: T,
}

impl<T: Real> Envelope<T> {
    /// Largest derivative, times the length of the ramp: half way.
    pub(crate) const STEEPEST: f64 = 1.875;
    /// Largest second derivative, times the square of that length: 10/sqrt(3).
    pub(crate) const MOST_CURVED: f64 = 5.773_502_691_896_258;

    /// At a time since the start, of a wave of this duration. A ramp of 0 is none.
    pub(crate) fn at(t_s: T, ramp_s: T, duration_s: T) -> Self {
        let left_s = duration_s - t_s;
        let (since_s, sign) = if t_s < ramp_s {
            (t_s, T::one())
        } else if left_s < ramp_s {
            (left_s, -T::one())
        } else {
            return Self {
                e: T::one(),
                de: T::zero(),
                dde: T::zero(),
            };
        };
        let per_s = T::one() / ramp_s;
        let (u, lit) = (since_s * per_s, T::lit);
        let left = T::one() - u;
        Self {
            e: u * u * u * (lit(10.0) + u * (lit(6.0) * u - lit(15.0))),
            de: lit(30.0) * u * u * left * left * per_s * sign,
            dde: lit(60.0) * u * left * (left - u) * per_s * per_s,
        }
    }
}
