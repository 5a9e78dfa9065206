//! Decoded instructions: what the decoder makes of an encoding, and what is executed.
//!
//! An [`Instruction`] is small, for many are kept decoded; encodings that do
//! the same are one instruction. Registers are numbers from 0 to 15.
//! Source: DDI 0403, chapter A7.

pub(crate) use super::operation::{
    Convert, Extend, FloatOp, Index, Kind, Lanes, LongMultiply, Multiply, Operation, Parallel,
    Reverse, Set, Shift,
};

/// A register's number.
pub(crate) type Reg = u8;

/// A decoded instruction.
#[rustfmt::skip]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instruction {
    /// Not decoded yet.
    Unknown,
    /// UNDEFINED by the architecture.
    Undefined,
    /// Unknown to this emulator, or UNPREDICTABLE.
    Unimplemented,
    /// An instruction of a coprocessor that does not exist.
    NoCoprocessor,

    /// `rotated`: the carry becomes bit 31 of `value`.
    Immediate { op: Operation, set: Set, d: Reg, n: Reg, rotated: bool, value: u32 },
    Register { op: Operation, set: Set, d: Reg, n: Reg, m: Reg, shift: Shift, amount: u8 },
    ShiftBy { shift: Shift, set: Set, d: Reg, n: Reg, m: Reg },
    MoveTop { d: Reg, value: u16 },
    /// Address relative to the program counter.
    Address { d: Reg, offset: i32 },
    /// MOV or ADD to the program counter.
    MoveToPc { m: Reg },
    AddToPc { m: Reg },

    Multiply { op: Multiply, d: Reg, n: Reg, m: Reg, a: Reg, set: Set },
    LongMultiply { op: LongMultiply, low: Reg, high: Reg, n: Reg, m: Reg },
    Divide { signed: bool, d: Reg, n: Reg, m: Reg },

    /// n of 15 adds nothing.
    Extend { kind: Extend, d: Reg, n: Reg, m: Reg, rotate: u8 },
    Reverse { kind: Reverse, d: Reg, m: Reg },
    /// n of 15 inserts zeros.
    Insert { d: Reg, n: Reg, lsb: u8, width: u8 },
    Extract { signed: bool, d: Reg, n: Reg, lsb: u8, width: u8 },
    Saturate { signed: bool, d: Reg, n: Reg, to: u8, shift: Shift, amount: u8 },
    SaturateHalves { signed: bool, d: Reg, n: Reg, to: u8 },
    SaturatingAdd { subtract: bool, double: bool, d: Reg, n: Reg, m: Reg },
    Pack { top: bool, d: Reg, n: Reg, m: Reg, amount: u8 },
    Parallel { lanes: Lanes, op: Parallel, d: Reg, n: Reg, m: Reg },
    Select { d: Reg, n: Reg, m: Reg },

    Load { kind: Kind, t: Reg, n: Reg, index: Index, offset: i32 },
    LoadIndexed { kind: Kind, t: Reg, n: Reg, m: Reg, amount: u8 },
    LoadLiteral { kind: Kind, t: Reg, offset: i32 },
    Store { kind: Kind, t: Reg, n: Reg, index: Index, offset: i32 },
    StoreIndexed { kind: Kind, t: Reg, n: Reg, m: Reg, amount: u8 },
    LoadDual { t: Reg, t2: Reg, n: Reg, index: Index, offset: i32 },
    StoreDual { t: Reg, t2: Reg, n: Reg, index: Index, offset: i32 },
    LoadMultiple { n: Reg, before: bool, write_back: bool, list: u16 },
    StoreMultiple { n: Reg, before: bool, write_back: bool, list: u16 },
    LoadExclusive { kind: Kind, t: Reg, n: Reg, offset: i32 },
    StoreExclusive { kind: Kind, d: Reg, t: Reg, n: Reg, offset: i32 },
    ClearExclusive,
    TableBranch { n: Reg, m: Reg, half: bool },

    Branch { offset: i32 },
    BranchIf { condition: u8, offset: i32 },
    BranchLink { offset: i32 },
    BranchExchange { m: Reg },
    BranchLinkExchange { m: Reg },
    CompareBranch { n: Reg, nonzero: bool, offset: i32 },
    IfThen { state: u8 },

    NoOperation,
    Barrier,
    WaitForEvent,
    WaitForInterrupt,
    SendEvent,
    Breakpoint { number: u8 },
    SupervisorCall,
    ChangeState { disable: bool, primask: bool, faultmask: bool },
    ReadSpecial { d: Reg, special: u8 },
    WriteSpecial { n: Reg, special: u8, mask: u8 },

    Float { op: FloatOp, d: Reg, n: Reg, m: Reg },
    FloatImmediate { d: Reg, bits: u32 },
    /// `with_zero`: m is not used.
    FloatCompare { d: Reg, m: Reg, with_zero: bool, signal: bool },
    FloatConvert { op: Convert, d: Reg, m: Reg },
    /// Between a core register and a single-precision one.
    FloatToCore { t: Reg, n: Reg },
    CoreToFloat { t: Reg, n: Reg },
    FloatPairToCore { t: Reg, t2: Reg, m: Reg },
    CoreToFloatPair { t: Reg, t2: Reg, m: Reg },
    /// 15 for t is the flags.
    ReadFloatStatus { t: Reg },
    WriteFloatStatus { t: Reg },
    /// Loads `count` registers from d on, of consecutive words.
    FloatLoad { d: Reg, count: u8, n: Reg, offset: i32 },
    FloatStore { d: Reg, count: u8, n: Reg, offset: i32 },
    FloatLoadMultiple { d: Reg, count: u8, n: Reg, before: bool, write_back: bool },
    FloatStoreMultiple { d: Reg, count: u8, n: Reg, before: bool, write_back: bool },
}
