//! Signals with edges and corners.

use super::sample::Sample;
use crate::real::Real;
use nalgebra::ComplexField;

/// Time in s before an edge within which a tick is taken to be on it: more than the rounding of
/// `f32` at ten minutes, and a small part of the shortest tick.
const EARLY_S: f64 = 1e-4;

/// Number of whole intervals that have passed, at most 65535.
pub(super) fn count<T: Real>(t_s: T, interval_s: T) -> u16 {
    let passed = (t_s + T::lit(EARLY_S)) / interval_s;
    ComplexField::floor(passed).to_count()
}

/// Counts from 0 to `peak` and back, periodically.
pub(super) fn back_and_forth(count: u16, peak: u8) -> u16 {
    let peak = u16::from(peak);
    // There is a step; asked for none, the first level.
    let turn = count.checked_rem(2 * peak).unwrap_or(0);
    turn.min(2 * peak - turn)
}

/// Level of this step; the ends exactly.
pub(super) fn between<T: Real>(from: T, to: T, level: u16, steps: u8) -> T {
    if level == u16::from(steps) && level > 0 {
        return to;
    }
    let share = T::from_count(level) / T::from_count(u16::from(steps.max(1)));
    from + (to - from) * share
}

/// After this many periods.
pub(super) fn triangle<T: Real>(offset: T, amplitude: T, turns: T, period_s: T) -> Sample<T> {
    let turn = turns - ComplexField::floor(turns);
    let four = T::lit(4.0);
    let slope = amplitude * four / period_s;
    let (share, first) = if turn < T::lit(0.25) {
        (four * turn, slope)
    } else if turn < T::lit(0.75) {
        (T::lit(2.0) - four * turn, -slope)
    } else {
        (four * turn - four, slope)
    };
    Sample {
        value: offset + amplitude * share,
        first,
        second: T::zero(),
    }
}

/// Heads or tails for an interval: the last bit of a hash, in which every bit of number
/// and seed counts (the last steps of `MurmurHash3`).
pub(super) fn chance(interval: u16, seed: u32) -> bool {
    let mut hash = seed ^ u32::from(interval).wrapping_mul(0x9E37_79B9);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85EB_CA6B);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xC2B2_AE35);
    (hash ^ (hash >> 16)) & 1 == 1
}
