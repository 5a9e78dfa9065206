//! 16-bit instructions. Source: DDI 0403, A5.2.

use super::super::arithmetic::sign_extend;
use super::super::instruction::{
    Extend, Index, Instruction, Kind, Multiply, Operation, Reg, Reverse, Set, Shift,
};
use super::{bit, field};

const SP: Reg = 13;

pub(super) fn decode(code: u32) -> Instruction {
    match code >> 11 {
        0b00000..=0b00010 => shift_immediate(code),
        0b00011 => add_subtract(code),
        0b00100..=0b00111 => immediate(code),
        0b01000 if code >> 10 & 1 == 0 => data_processing(code),
        0b01000 => special_data(code),
        0b01001 => Instruction::LoadLiteral {
            kind: Kind::Word,
            t: field(code, 8, 3),
            offset: (code & 0xFF) as i32 * 4,
        },
        0b01010 | 0b01011 => register_offset(code),
        0b01100..=0b10001 => immediate_offset(code),
        0b10010 | 0b10011 => {
            let (t, offset) = (field(code, 8, 3), (code & 0xFF) as i32 * 4);
            access(bit(code, 11), Kind::Word, t, SP, offset)
        }
        0b10100 => Instruction::Address {
            d: field(code, 8, 3),
            offset: (code & 0xFF) as i32 * 4,
        },
        0b10101 => add_to_sp(field(code, 8, 3), (code & 0xFF) * 4),
        0b10110 | 0b10111 => miscellaneous(code),
        // An empty list.
        0b11000 | 0b11001 if field(code, 0, 8) == 0 => Instruction::Unimplemented,
        0b11000 => Instruction::StoreMultiple {
            n: field(code, 8, 3),
            before: false,
            write_back: true,
            list: (code & 0xFF) as u16,
        },
        0b11001 => {
            let (n, list) = (field(code, 8, 3), (code & 0xFF) as u16);
            Instruction::LoadMultiple {
                n,
                before: false,
                write_back: list >> n & 1 == 0,
                list,
            }
        }
        0b11010 | 0b11011 => match field(code, 8, 4) {
            0b1110 => Instruction::Undefined,
            0b1111 => Instruction::SupervisorCall,
            condition => Instruction::BranchIf {
                condition,
                offset: sign_extend(code & 0xFF, 8) * 2,
            },
        },
        0b11100 => Instruction::Branch {
            offset: sign_extend(code & 0x7FF, 11) * 2,
        },
        // The first halfwords of 32-bit instructions.
        _ => Instruction::Unimplemented,
    }
}

fn shift_immediate(code: u32) -> Instruction {
    let amount = field(code, 6, 5);
    let (shift, amount) = match code >> 11 & 3 {
        0 => (Shift::Lsl, amount),
        1 => (Shift::Lsr, if amount == 0 { 32 } else { amount }),
        _ => (Shift::Asr, if amount == 0 { 32 } else { amount }),
    };
    Instruction::Register {
        op: Operation::Mov,
        set: Set::OutsideIt,
        d: field(code, 0, 3),
        n: 0,
        m: field(code, 3, 3),
        shift,
        amount,
    }
}

fn register(op: Operation, set: Set, d: Reg, n: Reg, m: Reg) -> Instruction {
    Instruction::Register {
        op,
        set,
        d,
        n,
        m,
        shift: Shift::Lsl,
        amount: 0,
    }
}

fn number(op: Operation, set: Set, d: Reg, n: Reg, value: u32) -> Instruction {
    Instruction::Immediate {
        op,
        set,
        d,
        n,
        rotated: false,
        value,
    }
}

fn add_subtract(code: u32) -> Instruction {
    let op = if bit(code, 9) {
        Operation::Sub
    } else {
        Operation::Add
    };
    let (d, n, m) = (field(code, 0, 3), field(code, 3, 3), field(code, 6, 3));
    if bit(code, 10) {
        number(op, Set::OutsideIt, d, n, u32::from(m))
    } else {
        register(op, Set::OutsideIt, d, n, m)
    }
}

fn immediate(code: u32) -> Instruction {
    let (d, value) = (field(code, 8, 3), code & 0xFF);
    match code >> 11 & 3 {
        0 => number(Operation::Mov, Set::OutsideIt, d, 0, value),
        1 => number(Operation::Cmp, Set::Always, 0, d, value),
        2 => number(Operation::Add, Set::OutsideIt, d, d, value),
        _ => number(Operation::Sub, Set::OutsideIt, d, d, value),
    }
}

fn data_processing(code: u32) -> Instruction {
    let (d, m) = (field(code, 0, 3), field(code, 3, 3));
    let two = |op| register(op, Set::OutsideIt, d, d, m);
    let by = |shift| Instruction::ShiftBy {
        shift,
        set: Set::OutsideIt,
        d,
        n: d,
        m,
    };
    match code >> 6 & 15 {
        0 => two(Operation::And),
        1 => two(Operation::Eor),
        2 => by(Shift::Lsl),
        3 => by(Shift::Lsr),
        4 => by(Shift::Asr),
        5 => two(Operation::Adc),
        6 => two(Operation::Sbc),
        7 => by(Shift::Ror),
        8 => register(Operation::Tst, Set::Always, 0, d, m),
        9 => number(Operation::Rsb, Set::OutsideIt, d, m, 0),
        10 => register(Operation::Cmp, Set::Always, 0, d, m),
        11 => register(Operation::Cmn, Set::Always, 0, d, m),
        12 => two(Operation::Orr),
        13 => Instruction::Multiply {
            op: Multiply::Mul,
            d,
            n: m,
            m: d,
            a: 0,
            set: Set::OutsideIt,
        },
        14 => two(Operation::Bic),
        _ => register(Operation::Mvn, Set::OutsideIt, d, 0, m),
    }
}

/// Those that take any register, and branches to one.
fn special_data(code: u32) -> Instruction {
    let (d, m) = (
        field(code, 0, 3) | field(code, 7, 1) << 3,
        field(code, 3, 4),
    );
    match (code >> 8 & 3, d) {
        (0, 15) => Instruction::AddToPc { m },
        (0, _) => register(Operation::Add, Set::Never, d, d, m),
        (1, _) => register(Operation::Cmp, Set::Always, 0, d, m),
        (2, 15) => Instruction::MoveToPc { m },
        (2, _) => register(Operation::Mov, Set::Never, d, 0, m),
        _ if code & 7 != 0 => Instruction::Unimplemented,
        _ if bit(code, 7) => Instruction::BranchLinkExchange { m },
        _ => Instruction::BranchExchange { m },
    }
}

fn access(load: bool, kind: Kind, t: Reg, n: Reg, offset: i32) -> Instruction {
    let index = Index::Offset;
    if load {
        Instruction::Load {
            kind,
            t,
            n,
            index,
            offset,
        }
    } else {
        Instruction::Store {
            kind,
            t,
            n,
            index,
            offset,
        }
    }
}

fn register_offset(code: u32) -> Instruction {
    let (t, n, m) = (field(code, 0, 3), field(code, 3, 3), field(code, 6, 3));
    let store = |kind| Instruction::StoreIndexed {
        kind,
        t,
        n,
        m,
        amount: 0,
    };
    let load = |kind| Instruction::LoadIndexed {
        kind,
        t,
        n,
        m,
        amount: 0,
    };
    match code >> 9 & 7 {
        0 => store(Kind::Word),
        1 => store(Kind::Half),
        2 => store(Kind::Byte),
        3 => load(Kind::SignedByte),
        4 => load(Kind::Word),
        5 => load(Kind::Half),
        6 => load(Kind::Byte),
        _ => load(Kind::SignedHalf),
    }
}

fn immediate_offset(code: u32) -> Instruction {
    let (t, n) = (field(code, 0, 3), field(code, 3, 3));
    let (kind, scale) = match code >> 12 {
        6 => (Kind::Word, 4),
        7 => (Kind::Byte, 1),
        _ => (Kind::Half, 2),
    };
    let offset = i32::from(field(code, 6, 5)) * scale;
    access(bit(code, 11), kind, t, n, offset)
}

fn add_to_sp(d: Reg, value: u32) -> Instruction {
    number(Operation::Add, Set::Never, d, SP, value)
}

fn miscellaneous(code: u32) -> Instruction {
    let (d, m) = (field(code, 0, 3), field(code, 3, 3));
    let extend = |kind| Instruction::Extend {
        kind,
        d,
        n: 15,
        m,
        rotate: 0,
    };
    let reverse = |kind| Instruction::Reverse { kind, d, m };
    match code >> 8 & 15 {
        0b0000 if bit(code, 7) => number(Operation::Sub, Set::Never, SP, SP, (code & 0x7F) * 4),
        0b0000 => add_to_sp(SP, (code & 0x7F) * 4),
        0b0001 | 0b0011 | 0b1001 | 0b1011 => Instruction::CompareBranch {
            n: d,
            nonzero: bit(code, 11),
            offset: (code >> 3 & 0x1F | (code >> 9 & 1) << 5) as i32 * 2,
        },
        0b0010 => match code >> 6 & 3 {
            0 => extend(Extend::SignedHalf),
            1 => extend(Extend::SignedByte),
            2 => extend(Extend::Half),
            _ => extend(Extend::Byte),
        },
        0b0100 | 0b0101 | 0b1100 | 0b1101 if field(code, 0, 8) == 0 && !bit(code, 8) => {
            Instruction::Unimplemented
        }
        0b0100 | 0b0101 => Instruction::StoreMultiple {
            n: SP,
            before: true,
            write_back: true,
            list: (code & 0xFF | (code >> 8 & 1) << 14) as u16,
        },
        0b0110 if code & 0xEC == 0x60 => Instruction::ChangeState {
            disable: bit(code, 4),
            primask: bit(code, 1),
            faultmask: bit(code, 0),
        },
        0b1010 => match code >> 6 & 3 {
            0 => reverse(Reverse::Bytes),
            1 => reverse(Reverse::BytesOfHalves),
            3 => reverse(Reverse::SignedHalf),
            _ => Instruction::Undefined,
        },
        0b1100 | 0b1101 => Instruction::LoadMultiple {
            n: SP,
            before: false,
            write_back: true,
            list: (code & 0xFF | (code >> 8 & 1) << 15) as u16,
        },
        0b1110 => Instruction::Breakpoint {
            number: (code & 0xFF) as u8,
        },
        0b1111 if code & 15 != 0 => Instruction::IfThen {
            state: (code & 0xFF) as u8,
        },
        0b1111 => hint(code >> 4 & 15),
        _ => Instruction::Undefined,
    }
}

/// Hints, which wide encodings share; those of no meaning are no operations.
pub(super) fn hint(number: u32) -> Instruction {
    match number {
        2 => Instruction::WaitForEvent,
        3 => Instruction::WaitForInterrupt,
        4 => Instruction::SendEvent,
        _ => Instruction::NoOperation,
    }
}
