//! Rounding, once, in any of the four modes.
//!
//! The rounded value is a double of 53 digits whose last one is odd wherever the exact number
//! has more digits ("round to odd"): it lies on the same side of each number of 24 digits, and
//! of each middle between two, as the exact one.
#![expect(clippy::float_cmp, reason = "whether a result is exact")]

use super::{SIGN, fpscr, is_zero};

/// Which of the neighbours a number is rounded to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Nearest,
    Up,
    Down,
    ToZero,
}

impl Mode {
    pub(super) fn of(status: u32) -> Self {
        match status >> 22 & 3 {
            0 => Self::Nearest,
            1 => Self::Up,
            2 => Self::Down,
            _ => Self::ToZero,
        }
    }
}

/// The sum of two doubles that came of single-precision numbers or their products, to odd.
#[inline]
pub(super) fn sticky_sum(a: f64, b: f64) -> f64 {
    let sum = a + b;
    // What the sum lacks, exactly (Knuth).
    let part = sum - a;
    let rest = (a - (sum - part)) + (b - part);
    if rest == 0.0 || sum.to_bits() & 1 != 0 || !rest.is_finite() {
        sum
    } else if rest > 0.0 {
        sum.next_up()
    } else {
        sum.next_down()
    }
}

/// The sum of two numbers whose sum is 0.
pub(super) fn zero_of_cancellation(status: u32, a: u32, b: u32) -> u32 {
    if is_zero(a) && is_zero(b) && (a ^ b) & SIGN == 0 {
        a & SIGN
    } else if Mode::of(status) == Mode::Down {
        SIGN
    } else {
        0
    }
}

/// Rounds a number other than 0 to single precision.
pub(super) fn round(status: &mut u32, value: f64) -> u32 {
    round_in(status, value, Mode::of(*status))
}

pub(super) fn round_in(status: &mut u32, value: f64, mode: Mode) -> u32 {
    // Before rounding.
    let tiny = value.abs() < f64::from(f32::MIN_POSITIVE);
    if tiny && *status & fpscr::FLUSH_TO_ZERO != 0 {
        *status |= fpscr::UNDERFLOW;
        return if value < 0.0 { SIGN } else { 0 };
    }
    let nearest = value as f32;
    let nearest_wide = f64::from(nearest);
    let result = match mode {
        Mode::Up if nearest_wide < value => nearest.next_up(),
        Mode::Down if nearest_wide > value => nearest.next_down(),
        Mode::ToZero if nearest_wide > value && value > 0.0 => nearest.next_down(),
        Mode::ToZero if nearest_wide < value && value < 0.0 => nearest.next_up(),
        _ => nearest,
    };
    if result.is_infinite() || value.abs() >= 2.0_f64.powi(128) {
        *status |= fpscr::OVERFLOW | fpscr::INEXACT;
    } else if f64::from(result) != value {
        *status |= fpscr::INEXACT | if tiny { fpscr::UNDERFLOW } else { 0 };
    }
    result.to_bits()
}

/// Rounds to an integer.
pub(super) fn to_whole(value: f64, mode: Mode) -> f64 {
    match mode {
        Mode::Nearest => value.round_ties_even(),
        Mode::Up => value.ceil(),
        Mode::Down => value.floor(),
        Mode::ToZero => value.trunc(),
    }
}
