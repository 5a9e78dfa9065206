//! Conversions between single-precision numbers and integers, fixed-point and half-precision
//! numbers. Source: DDI 0403, `FPToFixed`, `FixedToFP`, `FPHalfToSingle`, `FPSingleToHalf`.
#![expect(clippy::float_cmp, reason = "whether a result is exact")]

use super::round::{Mode, round_in, to_whole};
use super::{
    INFINITY, QUIET, QUIET_NAN, SIGN, fpscr, is_infinite, is_nan, is_signalling, is_zero, operand,
    wide,
};

/// To an integer of 32 bits, rounded as FPSCR says or towards zero.
pub(crate) fn to_integer(status: &mut u32, bits: u32, signed: bool, to_zero: bool) -> u32 {
    let mode = if to_zero {
        Mode::ToZero
    } else {
        Mode::of(*status)
    };
    to_number(status, bits, signed, 32, (0, mode))
}

/// To a fixed-point number with so many binary places, of 16 or 32 bits, extended to 32.
pub(crate) fn to_fixed(status: &mut u32, bits: u32, signed: bool, half: bool, places: u8) -> u32 {
    let width = if half { 16 } else { 32 };
    let places = (i32::from(places), Mode::ToZero);
    to_number(status, bits, signed, width, places)
}

fn to_number(
    status: &mut u32,
    bits: u32,
    signed: bool,
    width: u32,
    (places, mode): (i32, Mode),
) -> u32 {
    let bits = operand(status, bits);
    if is_nan(bits) {
        *status |= fpscr::INVALID;
        return 0;
    }
    let exact = wide(bits) * 2.0_f64.powi(places);
    let whole = to_whole(exact, mode);
    let (least, greatest) = if signed {
        let limit = 2.0_f64.powi(width as i32 - 1);
        (-limit, limit - 1.0)
    } else {
        (0.0, 2.0_f64.powi(width as i32) - 1.0)
    };
    let result = whole.clamp(least, greatest);
    if result != whole {
        *status |= fpscr::INVALID;
    } else if whole != exact {
        *status |= fpscr::INEXACT;
    }
    result as i64 as u32
}

/// From an integer, rounded as FPSCR says.
pub(crate) fn from_integer(status: &mut u32, value: u32, signed: bool) -> u32 {
    let mode = Mode::of(*status);
    from_number(status, number(value, signed), 0, mode)
}

/// From a fixed-point number, rounded to nearest.
pub(crate) fn from_fixed(
    status: &mut u32,
    value: u32,
    signed: bool,
    half: bool,
    places: u8,
) -> u32 {
    let value = match (half, signed) {
        (false, _) => number(value, signed),
        (true, true) => f64::from(value as i16),
        (true, false) => f64::from(value as u16),
    };
    from_number(status, value, i32::from(places), Mode::Nearest)
}

fn number(value: u32, signed: bool) -> f64 {
    if signed {
        f64::from(value as i32)
    } else {
        f64::from(value)
    }
}

fn from_number(status: &mut u32, value: f64, places: i32, mode: Mode) -> u32 {
    if value == 0.0 {
        return 0;
    }
    round_in(status, value * 2.0_f64.powi(-places), mode)
}

/// From a half-precision number.
pub(crate) fn from_half(status: &mut u32, half: u32) -> u32 {
    let sign = (half & 0x8000) << 16;
    let (exponent, fraction) = (half >> 10 & 31, half & 0x3FF);
    let alternative = *status & fpscr::ALTERNATIVE_HALF != 0;
    match exponent {
        0 => (fraction as f32 * 2.0_f32.powi(-24)).to_bits() | sign,
        31 if !alternative && fraction == 0 => INFINITY | sign,
        31 if !alternative => {
            if fraction & 0x200 == 0 {
                *status |= fpscr::INVALID;
            }
            if *status & fpscr::DEFAULT_NAN != 0 {
                QUIET_NAN
            } else {
                QUIET_NAN | sign | fraction << 13
            }
        }
        _ => sign | (exponent + 127 - 15) << 23 | fraction << 13,
    }
}

/// To a half-precision number.
pub(crate) fn to_half(status: &mut u32, bits: u32) -> u32 {
    let bits = operand(status, bits);
    let sign = (bits & SIGN) >> 16;
    let alternative = *status & fpscr::ALTERNATIVE_HALF != 0;
    if is_nan(bits) {
        if alternative || is_signalling(bits) {
            *status |= fpscr::INVALID;
        }
        return match (alternative, *status & fpscr::DEFAULT_NAN != 0) {
            (true, _) => sign,
            (false, true) => 0x7E00,
            (false, false) => sign | 0x7C00 | (bits | QUIET) >> 13 & 0x3FF,
        };
    }
    if is_infinite(bits) && alternative {
        *status |= fpscr::INVALID;
        return sign | 0x7FFF;
    }
    if is_infinite(bits) || is_zero(bits) {
        return sign | if is_zero(bits) { 0 } else { 0x7C00 };
    }
    sign | magnitude_to_half(status, bits, alternative)
}

fn magnitude_to_half(status: &mut u32, bits: u32, alternative: bool) -> u32 {
    let value = wide(bits & !SIGN);
    let mode = match (Mode::of(*status), bits & SIGN != 0) {
        (Mode::Up, true) => Mode::Down,
        (Mode::Down, true) => Mode::Up,
        (mode, _) => mode,
    };
    let exponent = ((bits >> 23 & 0xFF) as i32 - 127).max(-14);
    // In units of the last place: 1024 to 2047 if normal, up to 2048 by rounding.
    let exact = value * 2.0_f64.powi(10 - exponent);
    let whole = to_whole(exact, mode);
    let code = ((exponent + 14) << 10) as i64 + whole as i64;
    let limit = if alternative { 0x8000 } else { 0x7C00 };
    if code >= limit || exponent > 16 {
        if alternative {
            *status |= fpscr::INVALID;
            return 0x7FFF;
        }
        *status |= fpscr::OVERFLOW | fpscr::INEXACT;
        let down = matches!(mode, Mode::Down | Mode::ToZero);
        return if down { 0x7BFF } else { 0x7C00 };
    }
    if whole != exact {
        let tiny = value < 2.0_f64.powi(-14);
        *status |= fpscr::INEXACT | if tiny { fpscr::UNDERFLOW } else { 0 };
    }
    code as u32
}
