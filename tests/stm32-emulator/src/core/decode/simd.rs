//! 32-bit data processing of registers: shifts, extension, parallel arithmetic, multiplication.
//! Source: DDI 0403, A5.3.12 to A5.3.17.

use super::super::instruction::{
    Extend, Instruction, Lanes, LongMultiply, Multiply, Parallel, Reverse, Set, Shift,
};
use super::{bit, field};

pub(super) fn register(first: u32, second: u32) -> Instruction {
    let (n, d, m) = (field(first, 0, 4), field(second, 8, 4), field(second, 0, 4));
    if second >> 12 & 15 != 15 || d == 15 || m == 15 {
        return Instruction::Unimplemented;
    }
    match (bit(first, 7), second >> 6 & 3) {
        (false, 0) if field(second, 4, 2) == 0 => Instruction::ShiftBy {
            shift: match first >> 5 & 3 {
                0 => Shift::Lsl,
                1 => Shift::Lsr,
                2 => Shift::Asr,
                _ => Shift::Ror,
            },
            set: if bit(first, 4) {
                Set::Always
            } else {
                Set::Never
            },
            d,
            n,
            m,
        },
        (false, 2) => {
            let kind = match first >> 4 & 7 {
                0 => Extend::SignedHalf,
                1 => Extend::Half,
                2 => Extend::SignedBytes,
                3 => Extend::Bytes,
                4 => Extend::SignedByte,
                5 => Extend::Byte,
                _ => return Instruction::Undefined,
            };
            let rotate = field(second, 4, 2) * 8;
            Instruction::Extend {
                kind,
                d,
                n,
                m,
                rotate,
            }
        }
        (true, 0 | 1) => parallel(first, second),
        (true, 2) => miscellaneous(first, second),
        _ => Instruction::Unimplemented,
    }
}

fn parallel(first: u32, second: u32) -> Instruction {
    let op = match first >> 4 & 7 {
        0 => Parallel::Add8,
        1 => Parallel::Add16,
        2 => Parallel::AddSubtract,
        4 => Parallel::Subtract8,
        5 => Parallel::Subtract16,
        6 => Parallel::SubtractAdd,
        _ => return Instruction::Undefined,
    };
    let lanes = match second >> 4 & 7 {
        0 => Lanes::Signed,
        1 => Lanes::SignedSaturating,
        2 => Lanes::SignedHalving,
        4 => Lanes::Unsigned,
        5 => Lanes::UnsignedSaturating,
        6 => Lanes::UnsignedHalving,
        _ => return Instruction::Undefined,
    };
    Instruction::Parallel {
        lanes,
        op,
        d: field(second, 8, 4),
        n: field(first, 0, 4),
        m: field(second, 0, 4),
    }
}

fn miscellaneous(first: u32, second: u32) -> Instruction {
    let (n, d, m) = (field(first, 0, 4), field(second, 8, 4), field(second, 0, 4));
    let number = second >> 4 & 3;
    let kind = match (first >> 4 & 7, number) {
        (0, _) => {
            return Instruction::SaturatingAdd {
                subtract: bit(number, 1),
                double: bit(number, 0),
                d,
                n,
                m,
            };
        }
        (2, 0) => return Instruction::Select { d, n, m },
        (1, 0) => Reverse::Bytes,
        (1, 1) => Reverse::BytesOfHalves,
        (1, 2) => Reverse::Bits,
        (1, _) => Reverse::SignedHalf,
        (3, 0) => Reverse::Count,
        _ => return Instruction::Undefined,
    };
    Instruction::Reverse { kind, d, m }
}

pub(super) fn multiply(first: u32, second: u32) -> Instruction {
    let (n, d, m) = (field(first, 0, 4), field(second, 8, 4), field(second, 0, 4));
    let a = field(second, 12, 4);
    let (upper, lower) = (bit(second, 5), bit(second, 4));
    let op = match (first >> 4 & 7, upper, lower) {
        _ if second >> 6 & 3 != 0 => return Instruction::Undefined,
        // These have an addend in any case.
        (0, _, true) | (6, ..) if a == 15 => return Instruction::Unimplemented,
        (0, false, false) if a == 15 => Multiply::Mul,
        (0, false, false) => Multiply::Mla,
        (0, false, true) => Multiply::Mls,
        (1, n_top, m_top) => Multiply::Half { n_top, m_top },
        (3, false, m_top) => Multiply::Wide { m_top },
        (group @ (2 | 4), false, exchange) => Multiply::Dual {
            subtract: group == 4,
            exchange,
        },
        (group @ (5 | 6), false, round) => Multiply::Top {
            subtract: group == 6,
            round,
        },
        (7, false, false) => Multiply::AbsoluteDifferences,
        _ => return Instruction::Undefined,
    };
    let set = Set::Never;
    Instruction::Multiply {
        op,
        d,
        n,
        m,
        a,
        set,
    }
}

pub(super) fn long_multiply(first: u32, second: u32) -> Instruction {
    let (n, m) = (field(first, 0, 4), field(second, 0, 4));
    let (low, high) = (field(second, 12, 4), field(second, 8, 4));
    let (upper, lower) = (bit(second, 5), bit(second, 4));
    let op = match (first >> 4 & 7, second >> 4 & 15) {
        (1 | 3, 15) if low == 15 => {
            return Instruction::Divide {
                signed: !bit(first, 5),
                d: high,
                n,
                m,
            };
        }
        (0, 0) => LongMultiply::Signed,
        (2, 0) => LongMultiply::Unsigned,
        (4, 0) => LongMultiply::SignedAdd,
        (4, 8..=11) => LongMultiply::Half {
            n_top: upper,
            m_top: lower,
        },
        (group @ (4 | 5), 12 | 13) => LongMultiply::Dual {
            subtract: group == 5,
            exchange: lower,
        },
        (6, 0) => LongMultiply::UnsignedAdd,
        (6, 6) => LongMultiply::UnsignedAddTwice,
        _ => return Instruction::Undefined,
    };
    if low == high {
        return Instruction::Unimplemented;
    }
    Instruction::LongMultiply {
        op,
        low,
        high,
        n,
        m,
    }
}
