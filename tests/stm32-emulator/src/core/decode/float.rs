//! Instructions of the floating-point unit: single precision and moves of pairs.
//! Source: DDI 0403, A6.4 to A6.7.

use super::super::instruction::{Convert, FloatOp, Instruction, Reg};
use super::{bit, field};

pub(super) fn decode(first: u32, second: u32) -> Instruction {
    // What ARMv8-M adds is undefined here.
    if bit(first, 12) {
        return Instruction::Undefined;
    }
    match first >> 8 & 3 {
        2 if bit(second, 4) => transfer(first, second),
        2 if bit(second, 8) => Instruction::Undefined,
        2 => data(first, second),
        3 => Instruction::Undefined,
        _ if first >> 5 & 0x1D == 0 => pair(first, second),
        _ => memory(first, second),
    }
}

fn d(first: u32, second: u32) -> Reg {
    field(second, 12, 4) << 1 | field(first, 6, 1)
}

fn n(first: u32, second: u32) -> Reg {
    field(first, 0, 4) << 1 | field(second, 7, 1)
}

fn m(second: u32) -> Reg {
    field(second, 0, 4) << 1 | field(second, 5, 1)
}

fn data(first: u32, second: u32) -> Instruction {
    let op = match (bit(first, 7), first >> 4 & 3, bit(second, 6)) {
        (true, 3, _) => return other_data(first, second),
        (false, 0, false) => FloatOp::MultiplyAdd,
        (false, 0, true) => FloatOp::MultiplySubtract,
        (false, 1, false) => FloatOp::NegatedMultiplySubtract,
        (false, 1, true) => FloatOp::NegatedMultiplyAdd,
        (false, 2, false) => FloatOp::Multiply,
        (false, 2, true) => FloatOp::NegatedMultiply,
        (false, _, false) => FloatOp::Add,
        (false, _, true) => FloatOp::Subtract,
        (true, 0, false) => FloatOp::Divide,
        (true, 0, true) => return Instruction::Undefined,
        (true, 1, false) => FloatOp::NegatedFusedSubtract,
        (true, 1, true) => FloatOp::NegatedFused,
        (true, _, false) => FloatOp::Fused,
        (true, _, true) => FloatOp::FusedSubtract,
    };
    Instruction::Float {
        op,
        d: d(first, second),
        n: n(first, second),
        m: m(second),
    }
}

fn other_data(first: u32, second: u32) -> Instruction {
    let (d, m) = (d(first, second), m(second));
    let number = first & 15;
    let upper = bit(second, 7);
    let one = |op| Instruction::Float { op, d, n: m, m };
    let convert = |op| Instruction::FloatConvert { op, d, m };
    if !bit(second, 6) {
        if second & 0xA0 != 0 {
            return Instruction::Unimplemented;
        }
        return Instruction::FloatImmediate {
            d,
            bits: expand(number << 4 | second & 15),
        };
    }
    match (number, upper) {
        (0, false) => one(FloatOp::Move),
        (0, true) => one(FloatOp::Absolute),
        (1, false) => one(FloatOp::Negate),
        (1, true) => one(FloatOp::Root),
        (2, top) => convert(Convert::FromHalf { top }),
        (3, top) => convert(Convert::ToHalf { top }),
        (4, signal) => compare(d, m, false, signal),
        (5, signal) if m == 0 => compare(d, d, true, signal),
        (5, _) => Instruction::Unimplemented,
        (8, signed) => convert(Convert::FromInteger { signed }),
        (12 | 13, to_zero) => convert(Convert::ToInteger {
            signed: number == 13,
            to_zero,
        }),
        (10 | 11 | 14 | 15, word) => fixed(number, !word, d, second),
        _ => Instruction::Undefined,
    }
}

fn compare(d: Reg, m: Reg, with_zero: bool, signal: bool) -> Instruction {
    Instruction::FloatCompare {
        d,
        m,
        with_zero,
        signal,
    }
}

fn fixed(number: u32, half: bool, d: Reg, second: u32) -> Instruction {
    let size = if half { 16 } else { 32 };
    let imm = field(second, 0, 4) << 1 | field(second, 5, 1);
    if imm > size {
        return Instruction::Unimplemented;
    }
    let (signed, places) = (!bit(number, 0), size - imm);
    let op = if bit(number, 2) {
        Convert::ToFixed {
            signed,
            half,
            places,
        }
    } else {
        Convert::FromFixed {
            signed,
            half,
            places,
        }
    };
    Instruction::FloatConvert { op, d, m: d }
}

/// 8 bits as a single-precision number.
pub(super) fn expand(imm: u32) -> u32 {
    let exponent = if bit(imm, 6) { 0x1F } else { 0x20 };
    (imm >> 7) << 31 | exponent << 25 | (imm & 0x3F) << 19
}

/// Between one core register and a register of the unit.
fn transfer(first: u32, second: u32) -> Instruction {
    let (t, load, select) = (field(second, 12, 4), bit(first, 4), first >> 5 & 7);
    let n = match (bit(second, 8), select) {
        // Bits that should be zero are.
        _ if second & 0x6F != 0 => return Instruction::Unimplemented,
        _ if t == 15 && !load => return Instruction::Unimplemented,
        (false, 7) if bit(second, 7) => return Instruction::Unimplemented,
        (false, 0) => n(first, second),
        (false, 7) if first & 15 == 1 && load => return Instruction::ReadFloatStatus { t },
        (false, 7) if first & 15 == 1 => return Instruction::WriteFloatStatus { t },
        // Half of a double-precision register; there are 16 of these.
        (true, 0 | 1) if !bit(second, 7) => field(first, 0, 4) << 1 | field(first, 5, 1),
        _ => return Instruction::Undefined,
    };
    if load {
        Instruction::FloatToCore { t, n }
    } else {
        Instruction::CoreToFloat { t, n }
    }
}

/// Between two core registers and two of the unit.
fn pair(first: u32, second: u32) -> Instruction {
    let (t, t2) = (field(second, 12, 4), field(first, 0, 4));
    let double = bit(second, 8);
    if !bit(first, 6) || second >> 4 & 0xD != 1 || double && bit(second, 5) {
        return Instruction::Undefined;
    }
    let m = if double {
        field(second, 0, 4) << 1
    } else {
        m(second)
    };
    if m == 31 {
        Instruction::Unimplemented
    } else if bit(first, 4) {
        Instruction::FloatPairToCore { t, t2, m }
    } else {
        Instruction::CoreToFloatPair { t, t2, m }
    }
}

fn memory(first: u32, second: u32) -> Instruction {
    let n = field(first, 0, 4);
    let (before, up) = (bit(first, 8), bit(first, 7));
    let (write_back, load) = (bit(first, 5), bit(first, 4));
    let words = second & 0xFF;
    let double = bit(second, 8);
    let d = if double {
        field(second, 12, 4) << 1 | field(first, 6, 1) << 5
    } else {
        d(first, second)
    };
    if before && !write_back {
        let count = if double { 2 } else { 1 };
        let offset = words as i32 * 4;
        let offset = if up { offset } else { -offset };
        return match (load, d + count <= 32) {
            (_, false) => Instruction::Undefined,
            (true, _) => Instruction::FloatLoad {
                d,
                count,
                n,
                offset,
            },
            (false, _) => Instruction::FloatStore {
                d,
                count,
                n,
                offset,
            },
        };
    }
    if before == up {
        return Instruction::Undefined;
    }
    // An odd number of words of doubles is the obsolete FLDMX.
    if words == 0 || words + u32::from(d) > 32 || n == 15 || double && bit(words, 0) {
        return Instruction::Unimplemented;
    }
    let count = words as u8;
    if load {
        Instruction::FloatLoadMultiple {
            d,
            count,
            n,
            before,
            write_back,
        }
    } else {
        Instruction::FloatStoreMultiple {
            d,
            count,
            n,
            before,
            write_back,
        }
    }
}
