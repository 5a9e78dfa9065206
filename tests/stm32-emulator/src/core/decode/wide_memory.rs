//! 32-bit loads and stores, exclusives and table branches.
//! Source: DDI 0403, A5.3.5 to A5.3.10.

use super::super::instruction::{Index, Instruction, Kind, Reg};
use super::{bit, field};

/// Index and offset of an 8-bit immediate; `None` is another instruction.
fn index(second: u32) -> Option<(Index, i32)> {
    let (add, value) = (bit(second, 9), (second & 0xFF) as i32);
    let offset = if add { value } else { -value };
    match (bit(second, 10), bit(second, 8)) {
        (true, true) => Some((Index::Pre, offset)),
        (false, true) => Some((Index::Post, offset)),
        (true, false) if add => Some((Index::Unprivileged, offset)),
        (true, false) => Some((Index::Offset, offset)),
        (false, false) => None,
    }
}

fn kind(first: u32) -> Kind {
    match (first >> 5 & 3, bit(first, 8)) {
        (0, false) => Kind::Byte,
        (0, true) => Kind::SignedByte,
        (1, false) => Kind::Half,
        (1, true) => Kind::SignedHalf,
        _ => Kind::Word,
    }
}

pub(super) fn store(first: u32, second: u32) -> Instruction {
    let (n, t) = (field(first, 0, 4), field(second, 12, 4));
    let kind = kind(first);
    if n == 15 || t == 15 || bit(first, 8) || first >> 5 & 3 == 3 {
        return Instruction::Unimplemented;
    }
    let (index, offset) = if bit(first, 7) {
        (Index::Offset, (second & 0xFFF) as i32)
    } else if bit(second, 11) {
        match index(second) {
            Some(found) => found,
            None => return Instruction::Undefined,
        }
    } else if field(second, 6, 5) == 0 {
        return Instruction::StoreIndexed {
            kind,
            t,
            n,
            m: field(second, 0, 4),
            amount: field(second, 4, 2),
        };
    } else {
        return Instruction::Undefined;
    };
    if writes_back(index) && n == t {
        return Instruction::Unimplemented;
    }
    Instruction::Store {
        kind,
        t,
        n,
        index,
        offset,
    }
}

fn writes_back(index: Index) -> bool {
    matches!(index, Index::Pre | Index::Post)
}

pub(super) fn load(first: u32, second: u32) -> Instruction {
    let (n, t) = (field(first, 0, 4), field(second, 12, 4));
    let kind = kind(first);
    if first >> 5 & 3 == 3 || kind == Kind::Word && bit(first, 8) {
        return Instruction::Undefined;
    }
    // Bytes and halfwords into the program counter are hints to preload.
    let hint = t == 15 && kind != Kind::Word;
    if n == 15 {
        let value = (second & 0xFFF) as i32;
        let offset = if bit(first, 7) { value } else { -value };
        return if hint {
            Instruction::NoOperation
        } else {
            Instruction::LoadLiteral { kind, t, offset }
        };
    }
    let (index, offset) = if bit(first, 7) {
        (Index::Offset, (second & 0xFFF) as i32)
    } else if bit(second, 11) {
        match index(second) {
            Some(found) => found,
            None => return Instruction::Undefined,
        }
    } else if field(second, 6, 5) == 0 {
        if hint {
            return Instruction::NoOperation;
        }
        return Instruction::LoadIndexed {
            kind,
            t,
            n,
            m: field(second, 0, 4),
            amount: field(second, 4, 2),
        };
    } else {
        return Instruction::Undefined;
    };
    match index {
        Index::Offset if hint => Instruction::NoOperation,
        _ if hint || writes_back(index) && n == t => Instruction::Unimplemented,
        _ => Instruction::Load {
            kind,
            t,
            n,
            index,
            offset,
        },
    }
}

pub(super) fn multiple(first: u32, second: u32) -> Instruction {
    let (n, write_back, load) = (field(first, 0, 4), bit(first, 5), bit(first, 4));
    let list = second as u16;
    let before = match first >> 7 & 3 {
        1 => false,
        2 => true,
        _ => return Instruction::Undefined,
    };
    let has = |register: Reg| list >> register & 1 != 0;
    let branches = has(15) && (!load || has(14));
    if n == 15 || list.count_ones() < 2 || has(13) || branches || write_back && has(n) {
        Instruction::Unimplemented
    } else if load {
        Instruction::LoadMultiple {
            n,
            before,
            write_back,
            list,
        }
    } else {
        Instruction::StoreMultiple {
            n,
            before,
            write_back,
            list,
        }
    }
}

pub(super) fn dual_or_exclusive(first: u32, second: u32) -> Instruction {
    let (n, t, t2) = (
        field(first, 0, 4),
        field(second, 12, 4),
        field(second, 8, 4),
    );
    let load = bit(first, 4);
    let words = (second & 0xFF) as i32 * 4;
    if bit(first, 8) || bit(first, 5) {
        return dual(first, load, [n, t, t2], words);
    }
    let low = field(second, 0, 4);
    let kind = match (second >> 4 & 15, load) {
        _ if !bit(first, 7) && !load => return exclusive_store(Kind::Word, [t2, t, n], words),
        _ if !bit(first, 7) && t2 == 15 => return exclusive_load(Kind::Word, t, n, words),
        (half @ (0 | 1), true) if t == 15 && t2 == 0 => {
            let half = half == 1;
            return Instruction::TableBranch { n, m: low, half };
        }
        (4, _) if t2 == 15 => Kind::Byte,
        (5, _) if t2 == 15 => Kind::Half,
        _ => return Instruction::Unimplemented,
    };
    match (load, low) {
        (false, d) => exclusive_store(kind, [d, t, n], 0),
        (true, 15) => exclusive_load(kind, t, n, 0),
        _ => Instruction::Unimplemented,
    }
}

fn exclusive_load(kind: Kind, t: Reg, n: Reg, offset: i32) -> Instruction {
    Instruction::LoadExclusive { kind, t, n, offset }
}

fn exclusive_store(kind: Kind, [d, t, n]: [Reg; 3], offset: i32) -> Instruction {
    Instruction::StoreExclusive {
        kind,
        d,
        t,
        n,
        offset,
    }
}

fn dual(first: u32, load: bool, [n, t, t2]: [Reg; 3], words: i32) -> Instruction {
    let offset = if bit(first, 7) { words } else { -words };
    let index = match (bit(first, 8), bit(first, 5)) {
        (true, true) => Index::Pre,
        (true, false) => Index::Offset,
        _ => Index::Post,
    };
    let overwritten = writes_back(index) && (n == t || n == t2 || n == 15);
    let is_special = |register| register == 13 || register == 15;
    if overwritten || is_special(t) || is_special(t2) || load && t == t2 || !load && n == 15 {
        Instruction::Unimplemented
    } else if load {
        Instruction::LoadDual {
            t,
            t2,
            n,
            index,
            offset,
        }
    } else {
        Instruction::StoreDual {
            t,
            t2,
            n,
            index,
            offset,
        }
    }
}
