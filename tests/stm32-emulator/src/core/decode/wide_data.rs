//! 32-bit data processing with immediates and with shifted registers.
//! Source: DDI 0403, A5.3.1 to A5.3.3 and A5.3.11.

use super::super::instruction::{Instruction, Operation, Reg, Set, Shift};
use super::{bit, field};

/// An operation by its number, and how it uses d and n: `None` is none of these.
fn operation(first: u32, second: u32) -> Option<(Operation, Set, Reg, Reg)> {
    let (n, d, sets) = (field(first, 0, 4), field(second, 8, 4), bit(first, 4));
    let compares = d == 15 && sets;
    let (op, comparison) = match first >> 5 & 15 {
        0 => (Operation::And, Some(Operation::Tst)),
        1 => (Operation::Bic, None),
        2 if n == 15 => (Operation::Mov, None),
        2 => (Operation::Orr, None),
        3 if n == 15 => (Operation::Mvn, None),
        3 => (Operation::Orn, None),
        4 => (Operation::Eor, Some(Operation::Teq)),
        8 => (Operation::Add, Some(Operation::Cmn)),
        10 => (Operation::Adc, None),
        11 => (Operation::Sbc, None),
        13 => (Operation::Sub, Some(Operation::Cmp)),
        14 => (Operation::Rsb, None),
        _ => return None,
    };
    match comparison {
        Some(comparison) if compares => Some((comparison, Set::Always, 0, n)),
        // The program counter is not a result here.
        _ if d == 15 => None,
        _ if sets => Some((op, Set::Always, d, n)),
        _ => Some((op, Set::Never, d, n)),
    }
}

/// 12 bits as a 32-bit number, and whether it was rotated.
pub(super) fn expand(first: u32, second: u32) -> (u32, bool) {
    let (low, top) = (second & 0xFF, second >> 12 & 7 | (first >> 10 & 1) << 3);
    match top {
        0 => (low, false),
        1 => (low << 16 | low, false),
        2 => (low << 24 | low << 8, false),
        3 => (low << 24 | low << 16 | low << 8 | low, false),
        _ => {
            let places = top << 1 | low >> 7;
            ((low | 0x80).rotate_right(places), true)
        }
    }
}

pub(super) fn modified_immediate(first: u32, second: u32) -> Instruction {
    let Some((op, set, d, n)) = operation(first, second) else {
        return Instruction::Unimplemented;
    };
    let (value, rotated) = expand(first, second);
    Instruction::Immediate {
        op,
        set,
        d,
        n,
        rotated,
        value,
    }
}

/// A constant shift of a register operand.
fn shift(kind: u32, amount: u8) -> (Shift, u8) {
    let full = if amount == 0 { 32 } else { amount };
    match kind & 3 {
        0 => (Shift::Lsl, amount),
        1 => (Shift::Lsr, full),
        2 => (Shift::Asr, full),
        _ if amount == 0 => (Shift::Rrx, 1),
        _ => (Shift::Ror, amount),
    }
}

pub(super) fn shifted_register(first: u32, second: u32) -> Instruction {
    let amount = field(second, 12, 3) << 2 | field(second, 6, 2);
    let m = field(second, 0, 4);
    if first >> 5 & 15 == 6 && !bit(first, 4) && !bit(second, 4) {
        let top = bit(second, 5);
        return Instruction::Pack {
            top,
            d: field(second, 8, 4),
            n: field(first, 0, 4),
            m,
            amount: if top && amount == 0 { 32 } else { amount },
        };
    }
    let Some((op, set, d, n)) = operation(first, second) else {
        return Instruction::Unimplemented;
    };
    let (shift, amount) = shift(second >> 4, amount);
    Instruction::Register {
        op,
        set,
        d,
        n,
        m,
        shift,
        amount,
    }
}

pub(super) fn plain_immediate(first: u32, second: u32) -> Instruction {
    let (n, d) = (field(first, 0, 4), field(second, 8, 4));
    let low = second & 0xFF | (second >> 12 & 7) << 8 | (first >> 10 & 1) << 11;
    let lsb = field(second, 12, 3) << 2 | field(second, 6, 2);
    let last = field(second, 0, 5);
    let extract = |signed| Instruction::Extract {
        signed,
        d,
        n,
        lsb,
        width: last + 1,
    };
    let plain = |op, value| Instruction::Immediate {
        op,
        set: Set::Never,
        d,
        n,
        rotated: false,
        value,
    };
    match first >> 4 & 0x1F {
        // Bits that should be zero are.
        0b10000.. if bit(first, 10) || bit(second, 5) => Instruction::Unimplemented,
        0b00000 if n == 15 => Instruction::Address {
            d,
            offset: low as i32,
        },
        0b00000 => plain(Operation::Add, low),
        0b00100 => plain(Operation::Mov, low | (first & 15) << 12),
        0b01010 if n == 15 => Instruction::Address {
            d,
            offset: -(low as i32),
        },
        0b01010 => plain(Operation::Sub, low),
        0b01100 => Instruction::MoveTop {
            d,
            value: (low | (first & 15) << 12) as u16,
        },
        0b10000 | 0b10010 => saturate(true, first, second, lsb),
        0b11000 | 0b11010 => saturate(false, first, second, lsb),
        0b10100 if lsb + last < 32 => extract(true),
        0b11100 if lsb + last < 32 => extract(false),
        0b10110 if lsb <= last => Instruction::Insert {
            d,
            n,
            lsb,
            width: last + 1 - lsb,
        },
        _ => Instruction::Unimplemented,
    }
}

fn saturate(signed: bool, first: u32, second: u32, amount: u8) -> Instruction {
    let (n, d) = (field(first, 0, 4), field(second, 8, 4));
    let to = field(second, 0, 5) + u8::from(signed);
    let right = bit(first, 5);
    if right && amount == 0 {
        if bit(second, 4) {
            return Instruction::Unimplemented;
        }
        let to = field(second, 0, 4) + u8::from(signed);
        return Instruction::SaturateHalves { signed, d, n, to };
    }
    Instruction::Saturate {
        signed,
        d,
        n,
        to,
        shift: if right { Shift::Asr } else { Shift::Lsl },
        amount,
    }
}
