//! Arithmetic of single-precision numbers as the floating-point unit does it.
//!
//! Numbers are bits; the status is FPSCR, whose cumulative exceptions are set and whose
//! rounding mode, flush-to-zero and default-NaN bits are observed. Results are computed
//! exactly, or so that rounding makes no difference, and then rounded once; where the
//! exceptions are known already, the host's arithmetic is the same and quicker.
//! Source: DDI 0403, A2.5 and the functions `FPAdd`, `FPMulAdd`, `FPRound`, `FPProcessNaNs`.

mod convert;
mod round;

pub(crate) use convert::{from_fixed, from_half, from_integer, to_fixed, to_half, to_integer};
use round::{round, sticky_sum, zero_of_cancellation};

/// Bits of FPSCR.
pub(crate) mod fpscr {
    pub(crate) const INVALID: u32 = 1 << 0;
    pub(crate) const DIVIDE_BY_ZERO: u32 = 1 << 1;
    pub(crate) const OVERFLOW: u32 = 1 << 2;
    pub(crate) const UNDERFLOW: u32 = 1 << 3;
    pub(crate) const INEXACT: u32 = 1 << 4;
    pub(crate) const DENORMAL: u32 = 1 << 7;
    pub(crate) const ROUNDING: u32 = 3 << 22;
    pub(crate) const FLUSH_TO_ZERO: u32 = 1 << 24;
    pub(crate) const DEFAULT_NAN: u32 = 1 << 25;
    pub(crate) const ALTERNATIVE_HALF: u32 = 1 << 26;
    /// Bits that exist.
    pub(crate) const ALL: u32 = 0xF7C0_009F;
}

pub(crate) const SIGN: u32 = 1 << 31;
const INFINITY: u32 = 0x7F80_0000;
const LEAST_NORMAL: u32 = 0x0080_0000;
const QUIET: u32 = 1 << 22;
const QUIET_NAN: u32 = INFINITY | QUIET;

fn is_nan(bits: u32) -> bool {
    bits & !SIGN > INFINITY
}

fn is_signalling(bits: u32) -> bool {
    is_nan(bits) && bits & QUIET == 0
}

fn is_infinite(bits: u32) -> bool {
    bits & !SIGN == INFINITY
}

fn is_zero(bits: u32) -> bool {
    bits & !SIGN == 0
}

fn wide(bits: u32) -> f64 {
    f64::from(f32::from_bits(bits))
}

/// Whether the host's result is the unit's: nothing but INEXACT, which is set already.
#[inline]
fn is_usual(status: u32, result: f32) -> bool {
    let modes = fpscr::ROUNDING | fpscr::FLUSH_TO_ZERO | fpscr::INEXACT;
    // The least normal number may have been less before it was rounded: an underflow.
    let magnitude = result.to_bits() & !SIGN;
    status & modes == fpscr::INEXACT && (LEAST_NORMAL + 1..INFINITY).contains(&magnitude)
}

/// An operand: a denormal one is zero if these are flushed.
fn operand(status: &mut u32, bits: u32) -> u32 {
    let magnitude = bits & !SIGN;
    if *status & fpscr::FLUSH_TO_ZERO != 0 && magnitude != 0 && magnitude < LEAST_NORMAL {
        *status |= fpscr::DENORMAL;
        return bits & SIGN;
    }
    bits
}

/// The result if an operand is not a number: the first signalling one, or the first.
fn not_a_number(status: &mut u32, operands: &[u32]) -> Option<u32> {
    let signalling = operands.iter().find(|bits| is_signalling(**bits));
    if signalling.is_some() {
        *status |= fpscr::INVALID;
    }
    let first = signalling.or_else(|| operands.iter().find(|bits| is_nan(**bits)))?;
    if *status & fpscr::DEFAULT_NAN != 0 {
        Some(QUIET_NAN)
    } else {
        Some(first | QUIET)
    }
}

fn invalid(status: &mut u32) -> u32 {
    *status |= fpscr::INVALID;
    QUIET_NAN
}

/// Sum.
#[inline]
pub(crate) fn add(status: &mut u32, a: u32, b: u32) -> u32 {
    let sum = f32::from_bits(a) + f32::from_bits(b);
    if is_usual(*status, sum) {
        return sum.to_bits();
    }
    add_fully(status, a, b)
}

/// Difference. Unlike a sum with the negated operand, it leaves a NaN's sign.
#[inline]
pub(crate) fn subtract(status: &mut u32, a: u32, b: u32) -> u32 {
    if is_nan(b) {
        return add_fully(status, a, b);
    }
    add(status, a, b ^ SIGN)
}

fn add_fully(status: &mut u32, a: u32, b: u32) -> u32 {
    let (a, b) = (operand(status, a), operand(status, b));
    if let Some(nan) = not_a_number(status, &[a, b]) {
        return nan;
    }
    match (is_infinite(a), is_infinite(b)) {
        (true, true) if a != b => return invalid(status),
        (true, _) => return a,
        (_, true) => return b,
        _ => {}
    }
    let sum = sticky_sum(wide(a), wide(b));
    if sum == 0.0 {
        return zero_of_cancellation(*status, a, b);
    }
    round(status, sum)
}

/// Product.
#[inline]
pub(crate) fn multiply(status: &mut u32, a: u32, b: u32) -> u32 {
    let product = f32::from_bits(a) * f32::from_bits(b);
    if is_usual(*status, product) {
        return product.to_bits();
    }
    multiply_fully(status, a, b)
}

fn multiply_fully(status: &mut u32, a: u32, b: u32) -> u32 {
    let (a, b) = (operand(status, a), operand(status, b));
    if let Some(nan) = not_a_number(status, &[a, b]) {
        return nan;
    }
    let sign = (a ^ b) & SIGN;
    if is_infinite(a) || is_infinite(b) {
        if is_zero(a) || is_zero(b) {
            return invalid(status);
        }
        return INFINITY | sign;
    }
    if is_zero(a) || is_zero(b) {
        return sign;
    }
    // 48 digits at most.
    round(status, wide(a) * wide(b))
}

/// Quotient.
#[inline]
pub(crate) fn divide(status: &mut u32, a: u32, b: u32) -> u32 {
    let quotient = f32::from_bits(a) / f32::from_bits(b);
    if is_usual(*status, quotient) {
        return quotient.to_bits();
    }
    divide_fully(status, a, b)
}

fn divide_fully(status: &mut u32, a: u32, b: u32) -> u32 {
    let (a, b) = (operand(status, a), operand(status, b));
    if let Some(nan) = not_a_number(status, &[a, b]) {
        return nan;
    }
    let sign = (a ^ b) & SIGN;
    match (is_infinite(a), is_infinite(b)) {
        (true, true) => return invalid(status),
        (true, false) => return INFINITY | sign,
        (false, true) => return sign,
        _ => {}
    }
    match (is_zero(a), is_zero(b)) {
        (true, true) => invalid(status),
        (true, false) => sign,
        (false, true) => {
            *status |= fpscr::DIVIDE_BY_ZERO;
            INFINITY | sign
        }
        // A quotient of 24 digits by 24 that is none of 25 digits is further from one than
        // 53 digits may be wrong.
        _ => round(status, wide(a) / wide(b)),
    }
}

/// Square root.
#[inline]
pub(crate) fn root(status: &mut u32, a: u32) -> u32 {
    let root = f32::from_bits(a).sqrt();
    if is_usual(*status, root) {
        return root.to_bits();
    }
    let a = operand(status, a);
    if let Some(nan) = not_a_number(status, &[a]) {
        nan
    } else if is_zero(a) || a == INFINITY {
        a
    } else if a & SIGN != 0 {
        invalid(status)
    } else {
        // As for quotients.
        round(status, wide(a).sqrt())
    }
}

/// `addend + a * b`, rounded once.
#[inline]
pub(crate) fn multiply_add(status: &mut u32, addend: u32, a: u32, b: u32) -> u32 {
    let (x, y, z) = (wide(a), wide(b), wide(addend));
    let sum = sticky_sum(x * y, z);
    let result = sum as f32;
    if is_usual(*status, result) {
        return result.to_bits();
    }
    multiply_add_fully(status, addend, a, b)
}

fn multiply_add_fully(status: &mut u32, addend: u32, a: u32, b: u32) -> u32 {
    let addend = operand(status, addend);
    let (a, b) = (operand(status, a), operand(status, b));
    let no_product = is_infinite(a) && is_zero(b) || is_zero(a) && is_infinite(b);
    if let Some(nan) = not_a_number(status, &[addend, a, b]) {
        if no_product && !is_signalling(addend) {
            return invalid(status);
        }
        return nan;
    }
    if no_product {
        return invalid(status);
    }
    let sign = (a ^ b) & SIGN;
    if is_infinite(a) || is_infinite(b) {
        if is_infinite(addend) && addend & SIGN != sign {
            return invalid(status);
        }
        return INFINITY | sign;
    }
    if is_infinite(addend) {
        return addend;
    }
    let product = wide(a) * wide(b);
    let sum = sticky_sum(product, wide(addend));
    if sum == 0.0 {
        let product = if is_zero(a) || is_zero(b) {
            sign
        } else {
            sign | 1
        };
        return zero_of_cancellation(*status, product, addend);
    }
    round(status, sum)
}

/// N, Z, C and V of a comparison; a quiet NaN is invalid if it `signals`.
pub(crate) fn compare(status: &mut u32, a: u32, b: u32, signals: bool) -> u32 {
    let (a, b) = (operand(status, a), operand(status, b));
    if is_nan(a) || is_nan(b) {
        if signals || is_signalling(a) || is_signalling(b) {
            *status |= fpscr::INVALID;
        }
        return 0b0011;
    }
    let (a, b) = (f32::from_bits(a), f32::from_bits(b));
    match a.partial_cmp(&b) {
        Some(std::cmp::Ordering::Less) => 0b1000,
        Some(std::cmp::Ordering::Equal) => 0b0110,
        _ => 0b0010,
    }
}
