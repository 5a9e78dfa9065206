//! The decoder: encodings to [`Instruction`]s.
//!
//! A pure function of one or two halfwords, the same inside and outside of IT blocks.
//! UNPREDICTABLE encodings are decoded as the rule for other registers would, or are
//! [`Instruction::Unimplemented`]. Source: DDI 0403, A5 (tables) and A7.7 (encodings).

mod float;
mod narrow;
mod simd;
mod wide;
mod wide_data;
mod wide_memory;

use super::instruction::Instruction;

/// Whether this is the first halfword of a 32-bit instruction.
#[inline]
pub(crate) fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// Decodes a 16-bit instruction.
pub(crate) fn narrow(code: u16) -> Instruction {
    narrow::decode(u32::from(code))
}

/// Decodes a 32-bit instruction.
pub(crate) fn wide(first: u16, second: u16) -> Instruction {
    wide::decode(u32::from(first), u32::from(second))
}

/// `width` bits of a number from bit `low` on, as a register or a small number.
#[inline]
fn field(code: u32, low: u32, width: u32) -> u8 {
    (code >> low & ((1 << width) - 1)) as u8
}

/// One bit.
#[inline]
fn bit(code: u32, number: u32) -> bool {
    code >> number & 1 != 0
}
