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

use super::instruction::{Instruction, Operation, Reg};

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
    let instruction = wide::decode(u32::from(first), u32::from(second));
    if results(&instruction).contains(&15) {
        // UNPREDICTABLE: only loads may write the program counter, and these branch.
        Instruction::Unimplemented
    } else {
        instruction
    }
}

/// Registers that a 32-bit instruction writes other than by a load of words.
fn results(instruction: &Instruction) -> [Reg; 2] {
    use Instruction as I;
    match *instruction {
        I::Immediate { op, d, .. } | I::Register { op, d, .. } => match op {
            Operation::Tst | Operation::Teq | Operation::Cmp | Operation::Cmn => [0, 0],
            _ => [d, d],
        },
        I::ShiftBy { d, .. }
        | I::MoveTop { d, .. }
        | I::Address { d, .. }
        | I::Multiply { d, .. }
        | I::Divide { d, .. }
        | I::Extend { d, .. }
        | I::Reverse { d, .. }
        | I::Insert { d, .. }
        | I::Extract { d, .. }
        | I::Saturate { d, .. }
        | I::SaturateHalves { d, .. }
        | I::SaturatingAdd { d, .. }
        | I::Pack { d, .. }
        | I::Parallel { d, .. }
        | I::Select { d, .. }
        | I::StoreExclusive { d, .. }
        | I::ReadSpecial { d, .. } => [d, d],
        I::LongMultiply { low, high, .. } => [low, high],
        I::LoadDual { t, t2, .. } | I::FloatPairToCore { t, t2, .. } => [t, t2],
        I::LoadExclusive { t, .. } | I::FloatToCore { t, .. } => [t, t],
        _ => [0, 0],
    }
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
