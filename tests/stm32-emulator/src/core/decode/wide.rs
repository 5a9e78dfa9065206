//! 32-bit instructions: the groups, branches and system instructions. Source: DDI 0403, A5.3.

use super::super::arithmetic::sign_extend;
use super::super::instruction::Instruction;
use super::narrow::hint;
use super::{bit, field, float, simd, wide_data, wide_memory};

pub(super) fn decode(first: u32, second: u32) -> Instruction {
    let group = first >> 4 & 0x7F;
    match first >> 11 & 3 {
        1 | 3 if bit(group, 6) => coprocessor(first, second),
        1 if bit(group, 5) => wide_data::shifted_register(first, second),
        1 if bit(group, 2) => wide_memory::dual_or_exclusive(first, second),
        1 => wide_memory::multiple(first, second),
        2 if bit(second, 15) => branch_or_control(first, second),
        2 if bit(group, 5) => wide_data::plain_immediate(first, second),
        2 => wide_data::modified_immediate(first, second),
        3 if group >> 4 == 2 => simd::register(first, second),
        3 if group >> 3 == 6 => simd::multiply(first, second),
        3 if group >> 3 == 7 => simd::long_multiply(first, second),
        3 if group & 1 == 0 => wide_memory::store(first, second),
        3 => wide_memory::load(first, second),
        _ => Instruction::Unimplemented,
    }
}

fn coprocessor(first: u32, second: u32) -> Instruction {
    match second >> 8 & 15 {
        10 | 11 => float::decode(first, second),
        _ => Instruction::NoCoprocessor,
    }
}

fn branch_or_control(first: u32, second: u32) -> Instruction {
    let top = field(first, 6, 4);
    match (bit(second, 14), bit(second, 12)) {
        (false, false) if top >> 1 == 7 => control(first, second),
        (false, false) => Instruction::BranchIf {
            condition: top,
            offset: near(first, second),
        },
        (false, true) => Instruction::Branch {
            offset: far(first, second),
        },
        (true, true) => Instruction::BranchLink {
            offset: far(first, second),
        },
        (true, false) => Instruction::Undefined,
    }
}

/// Offset of a conditional branch, 21 bits.
fn near(first: u32, second: u32) -> i32 {
    let offset = (first >> 10 & 1) << 20
        | (second >> 11 & 1) << 19
        | (second >> 13 & 1) << 18
        | (first & 0x3F) << 12
        | (second & 0x7FF) << 1;
    sign_extend(offset, 21)
}

/// Offset of other branches, 25 bits.
fn far(first: u32, second: u32) -> i32 {
    let sign = first >> 10 & 1;
    let inverted = |place: u32| (second >> place ^ sign ^ 1) & 1;
    let offset = sign << 24
        | inverted(13) << 23
        | inverted(11) << 22
        | (first & 0x3FF) << 12
        | (second & 0x7FF) << 1;
    sign_extend(offset, 25)
}

fn control(first: u32, second: u32) -> Instruction {
    let special = (second & 0xFF) as u8;
    // Bits that should be zero or one are.
    let (n, rest) = (field(first, 0, 4), second & 0x2F00);
    match first >> 4 & 0x7F {
        0b0111000 if second & 0x2300 == 0 => Instruction::WriteSpecial {
            n,
            special,
            mask: field(second, 10, 2),
        },
        0b0111010 if n == 15 && rest == 0 => hint(second & 0xFF),
        0b0111011 if n == 15 && rest == 0xF00 => match second >> 4 & 15 {
            2 if special & 15 == 15 => Instruction::ClearExclusive,
            4..=6 => Instruction::Barrier,
            _ => Instruction::Unimplemented,
        },
        0b0111110 if n == 15 && second & 0x2000 == 0 => Instruction::ReadSpecial {
            d: field(second, 8, 4),
            special,
        },
        0b1111111 if bit(second, 13) => Instruction::Undefined,
        _ => Instruction::Unimplemented,
    }
}
