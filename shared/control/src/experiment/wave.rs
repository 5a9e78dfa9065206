//! Smooth signals, and their ramps.

use super::sample::Sample;
use crate::real::Real;
use crate::trajectory::ramp::Envelope;
use core::f64::consts::TAU;

/// Largest sum of cosines of amplitude 1 with Schroeder's phases, over `sqrt(lines)`,
/// for any number of lines: 1.5144 for three, less for all others.
const PEAK: f64 = 1.53;

/// A frequency that changes linearly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep<T> {
    from_hz: T,
    sweep_hz_s: T,
}

impl<T: Real> Sweep<T> {
    pub(super) fn steady(hz: T) -> Self {
        Self {
            from_hz: hz,
            sweep_hz_s: T::zero(),
        }
    }

    pub(super) fn between(from_hz: T, to_hz: T, duration_s: T) -> Self {
        Self {
            from_hz,
            sweep_hz_s: (to_hz - from_hz) / duration_s,
        }
    }

    /// `offset + amplitude sin`.
    pub(super) fn at(&self, offset: T, amplitude: T, t_s: T) -> Sample<T> {
        let mean_hz = self.from_hz + self.sweep_hz_s * t_s * T::lit(0.5);
        let (sin, cos) = (fraction(mean_hz * t_s) * T::lit(TAU)).sine_cosine();
        let omega = T::lit(TAU) * (self.from_hz + self.sweep_hz_s * t_s);
        let domega = T::lit(TAU) * self.sweep_hz_s;
        let wave = amplitude * sin;
        Sample {
            value: offset + wave,
            first: amplitude * omega * cos,
            second: amplitude * domega * cos - omega * omega * wave,
        }
    }
}

/// Cosines at the multiples of one frequency. Each is the one before turned by an angle
/// that itself turns, so that two pairs of sine and cosine do for all.
pub(super) fn multisine<T: Real>(amplitude: T, lowest_hz: T, lines: u8, t_s: T) -> Sample<T> {
    let lines = lines.max(1);
    let count = T::from_count(u16::from(lines));
    let each = amplitude / (T::lit(PEAK) * count.sqrt());
    let omega = T::lit(TAU) * lowest_hz;
    let mut step = Turn::from_turns(fraction(lowest_hz * t_s));
    let bend = Turn::from_turns(-T::one() / count);
    let mut line = Turn {
        cos: T::one(),
        sin: T::zero(),
    };
    let mut sum = Sample::level(T::zero());
    for k in 1..=u16::from(lines) {
        line = line.and(step);
        step = step.and(bend);
        let omega = omega * T::from_count(k);
        let value = each * line.cos;
        sum.value += value;
        sum.first -= omega * each * line.sin;
        sum.second -= omega * omega * value;
    }
    sum
}

/// An angle by its cosine and sine.
#[derive(Clone, Copy, Debug)]
struct Turn<T> {
    cos: T,
    sin: T,
}

impl<T: Real> Turn<T> {
    /// Rotation by a fraction of a turn.
    fn from_turns(part: T) -> Self {
        let (sin, cos) = (part * T::lit(TAU)).sine_cosine();
        Self { cos, sin }
    }

    /// One turn after the other.
    fn and(self, other: Self) -> Self {
        Self {
            cos: self.cos * other.cos - self.sin * other.sin,
            sin: self.sin * other.cos + self.cos * other.sin,
        }
    }
}

/// Fractional part of a number that is not negative, while whole ones are exact.
fn fraction<T: Real>(turns: T) -> T {
    turns - T::from_count(turns.to_count())
}

/// A signal with its ramps at both ends.
pub(super) fn ramped<T: Real>(signal: Sample<T>, t_s: T, ramp_s: T, duration_s: T) -> Sample<T> {
    let Envelope { e, de, dde } = Envelope::at(t_s, ramp_s, duration_s);
    Sample {
        value: e * signal.value,
        first: de * signal.value + e * signal.first,
        second: dde * signal.value + T::lit(2.0) * de * signal.first + e * signal.second,
    }
}
