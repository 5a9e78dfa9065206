//! Bounds of signals: of their numbers, and of the values that they reach.

use super::Signal;
use crate::real::Real;
use crate::trajectory::FREQUENCY_MAX_HZ;
use crate::trajectory::ramp::Envelope;
use core::f64::consts::TAU;
use nalgebra::ComplexField;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Shortest time between two edges, and shortest ramp, in s: ten ticks of 1 ms, and
/// at the longest duration still few enough to count them off with 16 bits.
pub const TIME_MIN_S: f64 = 0.01;

/// Most lines of a multisine.
pub const LINES_MAX: u8 = 32;

/// Bounds of the values of a signal, to within rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<T> {
    /// Least value.
    pub low: T,
    /// Most.
    pub high: T,
    /// Largest magnitudes of the first and the second derivative; `None` for a signal
    /// with edges or corners, or that does not begin at 0.
    pub derivatives: Option<[T; 2]>,
}

impl<T: Real> Bounds<T> {
    /// The end that is farther from 0.
    pub fn farthest(&self) -> T {
        if self.high.abs() >= self.low.abs() {
            self.high
        } else {
            self.low
        }
    }
}

/// Reason why parameters define no signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Flaw {
    /// One is not finite.
    NotFinite,
    /// A period, or a time between edges, is shorter than [`TIME_MIN_S`].
    Time,
    /// A ramp is shorter than [`TIME_MIN_S`] and not 0, or longer than half of it all.
    Ramp,
    /// A frequency is negative or above [`FREQUENCY_MAX_HZ`].
    Frequency,
    /// A number of steps is 0, or one of lines, or that is above [`LINES_MAX`].
    Count,
}

impl<T: Real> Signal<T> {
    /// The flaw of its parameters, for an experiment of this duration.
    pub fn flaw(&self, duration_s: T) -> Option<Flaw> {
        let finite = |values: &[T]| {
            let is_finite = values.iter().all(ComplexField::is_finite);
            (!is_finite).then_some(Flaw::NotFinite)
        };
        let lasting = |time_s: T| (time_s < T::lit(TIME_MIN_S)).then_some(Flaw::Time);
        let some = |count: u8| (count == 0).then_some(Flaw::Count);
        let ramp = |ramp_s: T| {
            let is_one = ramp_s >= T::lit(TIME_MIN_S) && ramp_s * T::lit(2.0) <= duration_s;
            (!is_one && ramp_s != T::zero()).then_some(Flaw::Ramp)
        };
        let frequency = |hz: T| {
            let is_one = hz >= T::zero() && hz <= T::lit(FREQUENCY_MAX_HZ);
            (!is_one).then_some(Flaw::Frequency)
        };
        match *self {
            Self::Constant(value) => finite(&[value]),
            Self::Triangle {
                offset,
                amplitude,
                period_s,
            } => finite(&[offset, amplitude, period_s]).or(lasting(period_s)),
            Self::Staircase {
                from,
                to,
                steps,
                dwell_s,
            } => finite(&[from, to, dwell_s])
                .or(some(steps))
                .or(lasting(dwell_s)),
            Self::Steps {
                first,
                increment,
                steps,
                on_s,
                off_s,
                ..
            } => finite(&[first, increment, on_s, off_s])
                .or(some(steps))
                .or(lasting(on_s))
                .or((off_s < T::zero()).then_some(Flaw::Time)),
            Self::Sinusoid {
                offset,
                amplitude,
                frequency_hz,
                ramp_s,
            } => finite(&[offset, amplitude, frequency_hz, ramp_s])
                .or(frequency(frequency_hz))
                .or(ramp(ramp_s)),
            Self::Chirp {
                offset,
                amplitude,
                from_hz,
                to_hz,
                ramp_s,
            } => finite(&[offset, amplitude, from_hz, to_hz, ramp_s])
                .or(frequency(from_hz))
                .or(frequency(to_hz))
                .or(ramp(ramp_s)),
            Self::Multisine {
                amplitude,
                lowest_hz,
                lines,
                ramp_s,
            } => finite(&[amplitude, lowest_hz, ramp_s])
                .or(some(lines))
                .or((lines > LINES_MAX).then_some(Flaw::Count))
                .or(frequency(lowest_hz * T::from_count(lines.into())))
                .or(ramp(ramp_s)),
            Self::Prbs {
                amplitude, hold_s, ..
            } => finite(&[amplitude, hold_s]).or(lasting(hold_s)),
        }
    }

    /// Bounds of its values within this duration. Values are tight, but for a wave
    /// that ends before it has reached them; derivatives are those of the steepest ramp
    /// and the steepest wave, were they to coincide.
    pub fn bounds(&self, duration_s: T) -> Bounds<T> {
        let zero = T::zero();
        let edged = |low: T, high: T| Bounds {
            low: low.min(high),
            high: low.max(high),
            derivatives: None,
        };
        match *self {
            Self::Constant(value) => Bounds {
                low: value,
                high: value,
                derivatives: (value == zero).then_some([zero; 2]),
            },
            Self::Triangle {
                offset, amplitude, ..
            } => edged(offset - amplitude, offset + amplitude),
            Self::Staircase { from, to, .. } => edged(from, to),
            Self::Steps {
                first,
                increment,
                steps,
                alternating,
                ..
            } => {
                let last = first + increment * T::from_count(u16::from(steps.max(1)) - 1);
                let (low, high) = (first.min(last).min(zero), first.max(last).max(zero));
                if alternating {
                    let peak = high.max(-low);
                    edged(-peak, peak)
                } else {
                    edged(low, high)
                }
            }
            Self::Sinusoid {
                offset,
                amplitude,
                frequency_hz,
                ramp_s,
            } => Wave {
                offset,
                amplitude,
                omega: T::lit(TAU) * frequency_hz,
                domega: zero,
            }
            .ramped(ramp_s),
            Self::Chirp {
                offset,
                amplitude,
                from_hz,
                to_hz,
                ramp_s,
            } => Wave {
                offset,
                amplitude,
                omega: T::lit(TAU) * from_hz.max(to_hz),
                domega: T::lit(TAU) * (to_hz - from_hz).abs() / duration_s,
            }
            .ramped(ramp_s),
            // A sum of lines that stays below a bound changes no faster than the
            // highest line of that amplitude (Bernstein).
            Self::Multisine {
                amplitude,
                lowest_hz,
                lines,
                ramp_s,
            } => Wave {
                offset: zero,
                amplitude,
                omega: T::lit(TAU) * lowest_hz * T::from_count(lines.into()),
                domega: zero,
            }
            .ramped(ramp_s),
            Self::Prbs { amplitude, .. } => edged(-amplitude, amplitude),
        }
    }
}

/// Wave bounds before the envelope.
struct Wave<T> {
    offset: T,
    amplitude: T,
    /// Highest, in rad/s.
    omega: T,
    /// Its rate of change, in rad/s^2.
    domega: T,
}

impl<T: Real> Wave<T> {
    fn ramped(&self, ramp_s: T) -> Bounds<T> {
        let amplitude = self.amplitude.abs();
        let (low, high) = (self.offset - amplitude, self.offset + amplitude);
        if ramp_s <= T::zero() {
            return Bounds {
                low,
                high,
                derivatives: None,
            };
        }
        let per_s = T::one() / ramp_s;
        let de = T::lit(Envelope::<T>::STEEPEST) * per_s;
        let dde = T::lit(Envelope::<T>::MOST_CURVED) * per_s * per_s;
        let value = self.offset.abs() + amplitude;
        let first = amplitude * self.omega;
        let second = amplitude * (self.omega * self.omega + self.domega);
        Bounds {
            low: low.min(T::zero()),
            high: high.max(T::zero()),
            derivatives: Some([
                de * value + first,
                dde * value + T::lit(2.0) * de * first + second,
            ]),
        }
    }
}
