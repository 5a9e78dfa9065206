//! The signals, and their value at a time.

use super::sample::Sample;
use super::{pulse, wave};
use crate::real::Real;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// A function of time. Amplitudes may have either sign.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
#[cfg_attr(
    feature = "postcard",
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Signal<T> {
    /// The same from beginning to end.
    Constant(T),
    /// Straight lines between `offset - amplitude` and `offset + amplitude`; begins at
    /// the offset, upwards.
    Triangle {
        /// In the middle.
        offset: T,
        /// From there to either end.
        amplitude: T,
        /// Up, down, and back to the middle, in s.
        period_s: T,
    },
    /// Levels from one value to the other and back, again and again until the end.
    Staircase {
        /// The first level.
        from: T,
        /// The level half way.
        to: T,
        /// From one to the other.
        steps: u8,
        /// For each level, in s.
        dwell_s: T,
    },
    /// Pulses that grow, with nothing between them, and nothing after the last.
    Steps {
        /// Height of the first.
        first: T,
        /// Height increment per pulse.
        increment: T,
        /// Number of heights.
        steps: u8,
        /// Length of a pulse, in s.
        on_s: T,
        /// Of the pause after it, in s.
        off_s: T,
        /// Each height twice: as it is, then with the other sign.
        alternating: bool,
    },
    /// `e(t) (offset + amplitude sin(2 pi f t))`, e growing from 0 to 1 within the
    /// ramp, and falling back within the last of it.
    Sinusoid {
        /// In the middle.
        offset: T,
        /// From there to either end.
        amplitude: T,
        /// In Hz.
        frequency_hz: T,
        /// In s; 0 for none.
        ramp_s: T,
    },
    /// The same with a frequency that changes linearly with time.
    Chirp {
        /// In the middle.
        offset: T,
        /// From there to either end.
        amplitude: T,
        /// At the beginning, in Hz.
        from_hz: T,
        /// At the end, in Hz.
        to_hz: T,
        /// In s; 0 for none.
        ramp_s: T,
    },
    /// `e(t) a sum of cos(2 pi k f t + phase k)`, k from 1 to `lines`, with Schroeder's
    /// phases `-pi k (k-1) / lines`, which keep the peak low. `a` is
    /// `amplitude / (1.53 sqrt(lines))`: with it no sum of up to
    /// [`LINES_MAX`](super::LINES_MAX) lines is ever beyond the amplitude.
    Multisine {
        /// Bound of the peak.
        amplitude: T,
        /// The first line, and the distance of the others, in Hz.
        lowest_hz: T,
        /// Their number.
        lines: u8,
        /// In s; 0 for none.
        ramp_s: T,
    },
    /// Plus or minus the amplitude, by chance: the sign of an interval is a hash of its
    /// number and the seed.
    Prbs {
        /// Either way from 0.
        amplitude: T,
        /// Length of an interval, in s.
        hold_s: T,
        /// Another gives another sequence.
        seed: u32,
    },
}

impl<T: Real> Signal<T> {
    /// The same signal with all its values times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: T) -> Self {
        let [first, second] = match &mut self {
            Self::Constant(value) => [Some(value), None],
            Self::Triangle {
                offset, amplitude, ..
            }
            | Self::Sinusoid {
                offset, amplitude, ..
            }
            | Self::Chirp {
                offset, amplitude, ..
            } => [Some(offset), Some(amplitude)],
            Self::Staircase { from, to, .. } => [Some(from), Some(to)],
            Self::Steps {
                first, increment, ..
            } => [Some(first), Some(increment)],
            Self::Multisine { amplitude, .. } | Self::Prbs { amplitude, .. } => {
                [Some(amplitude), None]
            }
        };
        for value in [first, second].into_iter().flatten() {
            *value *= factor;
        }
        self
    }

    /// Value at `t_s` after the beginning, if it has no [flaw](Signal::flaw) and
    /// the experiment takes `duration_s`. Not finite only if its numbers are not.
    pub fn at(&self, t_s: T, duration_s: T) -> Sample<T> {
        let t_s = t_s.max(T::zero()).min(duration_s);
        match *self {
            Self::Constant(value) => Sample::level(value),
            Self::Triangle {
                offset,
                amplitude,
                period_s,
            } => pulse::triangle(offset, amplitude, t_s / period_s, period_s),
            Self::Staircase {
                from,
                to,
                steps,
                dwell_s,
            } => {
                let level = pulse::back_and_forth(pulse::count(t_s, dwell_s), steps);
                Sample::level(pulse::between(from, to, level, steps))
            }
            Self::Steps {
                first,
                increment,
                steps,
                on_s,
                off_s,
                alternating,
            } => {
                let cycle_s = on_s + off_s;
                let pulse = pulse::count(t_s, cycle_s);
                let is_on = pulse::count(t_s - T::from_count(pulse) * cycle_s, on_s) == 0;
                let (height, is_back) = if alternating {
                    (pulse / 2, pulse % 2 == 1)
                } else {
                    (pulse, false)
                };
                Sample::level(if is_on && height < u16::from(steps) {
                    let value = first + increment * T::from_count(height);
                    if is_back { -value } else { value }
                } else {
                    T::zero()
                })
            }
            Self::Sinusoid {
                offset,
                amplitude,
                frequency_hz,
                ramp_s,
            } => {
                let sweep = wave::Sweep::steady(frequency_hz);
                wave::ramped(sweep.at(offset, amplitude, t_s), t_s, ramp_s, duration_s)
            }
            Self::Chirp {
                offset,
                amplitude,
                from_hz,
                to_hz,
                ramp_s,
            } => {
                let sweep = wave::Sweep::between(from_hz, to_hz, duration_s);
                wave::ramped(sweep.at(offset, amplitude, t_s), t_s, ramp_s, duration_s)
            }
            Self::Multisine {
                amplitude,
                lowest_hz,
                lines,
                ramp_s,
            } => {
                let sum = wave::multisine(amplitude, lowest_hz, lines, t_s);
                wave::ramped(sum, t_s, ramp_s, duration_s)
            }
            Self::Prbs {
                amplitude,
                hold_s,
                seed,
            } => Sample::level(if pulse::chance(pulse::count(t_s, hold_s), seed) {
                amplitude
            } else {
                -amplitude
            }),
        }
    }
}
