//! Multiplication and division. Source: DDI 0403, A4.4.3, A4.4.5 and A7.7.

use super::super::Core;
use super::super::cycles::division;
use super::super::fault::Fault;
use super::super::instruction::{LongMultiply, Multiply, Reg, Set};
use super::super::system_control::ccr;
use super::Outcome;

/// One half of a word, signed.
fn half(value: u32, top: bool) -> i64 {
    i64::from(if top { value >> 16 } else { value } as i16)
}

/// Products of the halves, low and high, of one operand and the other or its exchange.
fn products(n: u32, m: u32, exchange: bool) -> (i64, i64) {
    (
        half(n, false) * half(m, exchange),
        half(n, true) * half(m, !exchange),
    )
}

impl Core {
    pub(super) fn multiply(&mut self, op: Multiply, [d, n, m, a]: [Reg; 4], set: Set) {
        let (x, y) = (self.get(n), self.get(m));
        let addend = if a == 15 { 0 } else { self.get(a) };
        // Sums of signed numbers saturate nothing, but say if they overflowed.
        let signed = |product: i64| {
            let sum = product + i64::from(addend as i32);
            (sum as u32, i64::from(sum as i32) != sum)
        };
        let (result, overflows) = match op {
            Multiply::Mul => (x.wrapping_mul(y), false),
            Multiply::Mla => (addend.wrapping_add(x.wrapping_mul(y)), false),
            Multiply::Mls => (self.get(a).wrapping_sub(x.wrapping_mul(y)), false),
            Multiply::Half { n_top, m_top } => signed(half(x, n_top) * half(y, m_top)),
            Multiply::Wide { m_top } => signed((i64::from(x as i32) * half(y, m_top)) >> 16),
            Multiply::Dual { subtract, exchange } => {
                let (low, high) = products(x, y, exchange);
                signed(if subtract { low - high } else { low + high })
            }
            Multiply::Top { subtract, round } => {
                let product = i64::from(x as i32) * i64::from(y as i32);
                let addend = i64::from(addend as i32) << 32;
                let sum = if subtract {
                    addend.wrapping_sub(product)
                } else {
                    addend.wrapping_add(product)
                };
                let rounding = i64::from(round) << 31;
                ((sum.wrapping_add(rounding) >> 32) as u32, false)
            }
            Multiply::AbsoluteDifferences => {
                let bytes = x.to_le_bytes().into_iter().zip(y.to_le_bytes());
                let sum: u32 = bytes.map(|(x, y)| u32::from(x.abs_diff(y))).sum();
                (addend.wrapping_add(sum), false)
            }
        };
        self.saturated |= overflows;
        if self.sets(set) {
            self.set_nz(result);
        }
        self.put(d, result);
    }

    pub(super) fn long_multiply(&mut self, op: LongMultiply, [low, high, n, m]: [Reg; 4]) {
        let (x, y) = (self.get(n), self.get(m));
        let (old_low, old_high) = (u64::from(self.get(low)), u64::from(self.get(high)));
        let old = old_high << 32 | old_low;
        let unsigned = u64::from(x) * u64::from(y);
        let signed = (i64::from(x as i32) * i64::from(y as i32)) as u64;
        let result = match op {
            LongMultiply::Unsigned => unsigned,
            LongMultiply::Signed => signed,
            LongMultiply::UnsignedAdd => old.wrapping_add(unsigned),
            LongMultiply::SignedAdd => old.wrapping_add(signed),
            // Cannot overflow.
            LongMultiply::UnsignedAddTwice => unsigned + old_low + old_high,
            LongMultiply::Half { n_top, m_top } => {
                old.wrapping_add((half(x, n_top) * half(y, m_top)) as u64)
            }
            LongMultiply::Dual { subtract, exchange } => {
                let (low, high) = products(x, y, exchange);
                let sum = if subtract { low - high } else { low + high };
                old.wrapping_add(sum as u64)
            }
        };
        self.put(low, result as u32);
        self.put(high, (result >> 32) as u32);
    }

    pub(super) fn divide(&mut self, signed: bool, d: Reg, n: Reg, m: Reg) -> Outcome {
        let (x, y) = (self.get(n), self.get(m));
        if y == 0 && self.control.ccr & ccr::DIV_0_TRP != 0 {
            return Err(Fault::DivideByZero.into());
        }
        let (quotient, cycles) = if signed {
            let (x, y) = (x as i32, y as i32);
            let quotient = if y == 0 { 0 } else { x.wrapping_div(y) as u32 };
            (quotient, division(x.unsigned_abs(), y.unsigned_abs()))
        } else {
            (x.checked_div(y).unwrap_or(0), division(x, y))
        };
        self.put(d, quotient);
        Ok(cycles)
    }
}
