//! Decoded instructions: what the decoder makes of an encoding, and what is executed.
//!
//! An [`Instruction`] is small and copied out of the store of decoded ones; encodings that do
//! the same are one instruction. Registers are numbers from 0 to 15.
//! Source: DDI 0403, chapter A7.

/// A register's number.
pub(crate) type Reg = u8;

/// When an instruction of data processing sets the flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Set {
    /// Never.
    Never,
    /// Always.
    Always,
    /// Outside IT blocks: most 16-bit encodings.
    OutsideIt,
}

/// Operation of data processing on two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    And,
    Bic,
    Orr,
    Orn,
    Eor,
    Add,
    Adc,
    Sub,
    Sbc,
    Rsb,
    Mov,
    Mvn,
    Tst,
    Teq,
    Cmp,
    Cmn,
}

/// Kind of a shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shift {
    Lsl,
    Lsr,
    Asr,
    Ror,
    /// By one place through the carry.
    Rrx,
}

/// What a load or a store moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Byte,
    Half,
    Word,
    SignedByte,
    SignedHalf,
}

/// How the base register of an access is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Index {
    /// Address is base plus offset.
    Offset,
    /// The same, and the base becomes it.
    Pre,
    /// Address is the base, to which the offset is added.
    Post,
    /// Address is base plus offset, with the rights of unprivileged code.
    Unprivileged,
}

/// Multiplication with a 32-bit result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Multiply {
    Mul,
    Mla,
    Mls,
    /// Halfwords: operands are the top ones of n, of m.
    Half {
        n_top: bool,
        m_top: bool,
    },
    /// Word by halfword.
    Wide {
        m_top: bool,
    },
    /// Dual, with difference and with exchange of the halves of m.
    Dual {
        subtract: bool,
        exchange: bool,
    },
    /// Most significant word, with difference and with rounding.
    Top {
        subtract: bool,
        round: bool,
    },
    /// Sum of absolute differences of bytes.
    AbsoluteDifferences,
}

/// Multiplication with a 64-bit result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LongMultiply {
    Unsigned,
    Signed,
    UnsignedAdd,
    SignedAdd,
    UnsignedAddTwice,
    /// Halfwords, added.
    Half {
        n_top: bool,
        m_top: bool,
    },
    /// Dual, added.
    Dual {
        subtract: bool,
        exchange: bool,
    },
}

/// Extension of a byte, of two bytes or of a halfword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extend {
    SignedByte,
    SignedBytes,
    SignedHalf,
    Byte,
    Bytes,
    Half,
}

/// Operation of one operand on bits or bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reverse {
    Bytes,
    BytesOfHalves,
    SignedHalf,
    Bits,
    /// Leading zeros.
    Count,
}

/// What a parallel addition or subtraction does with its results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lanes {
    Signed,
    SignedSaturating,
    SignedHalving,
    Unsigned,
    UnsignedSaturating,
    UnsignedHalving,
}

/// The lanes of a parallel addition or subtraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parallel {
    Add16,
    AddSubtract,
    SubtractAdd,
    Subtract16,
    Add8,
    Subtract8,
}

/// Arithmetic of single-precision numbers on up to three registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FloatOp {
    Add,
    Subtract,
    Multiply,
    NegatedMultiply,
    Divide,
    MultiplyAdd,
    MultiplySubtract,
    NegatedMultiplyAdd,
    NegatedMultiplySubtract,
    Fused,
    FusedSubtract,
    NegatedFused,
    NegatedFusedSubtract,
    Move,
    Absolute,
    Negate,
    Root,
}

/// Conversion between single-precision numbers and others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Convert {
    /// To an integer, rounded as FPSCR says or towards zero.
    ToInteger {
        signed: bool,
        to_zero: bool,
    },
    FromInteger {
        signed: bool,
    },
    /// To a fixed-point number of 32 or 16 bits with this many binary places.
    ToFixed {
        signed: bool,
        half: bool,
        places: u8,
    },
    FromFixed {
        signed: bool,
        half: bool,
        places: u8,
    },
    ToHalf {
        top: bool,
    },
    FromHalf {
        top: bool,
    },
}

/// A decoded instruction.
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
    Immediate {
        op: Operation,
        set: Set,
        d: Reg,
        n: Reg,
        rotated: bool,
        value: u32,
    },
    Register {
        op: Operation,
        set: Set,
        d: Reg,
        n: Reg,
        m: Reg,
        shift: Shift,
        amount: u8,
    },
    ShiftBy {
        shift: Shift,
        set: Set,
        d: Reg,
        n: Reg,
        m: Reg,
    },
    MoveTop {
        d: Reg,
        value: u16,
    },
    /// Address relative to the program counter.
    Address {
        d: Reg,
        offset: i32,
    },
    /// MOV or ADD to the program counter.
    MoveToPc {
        m: Reg,
    },
    AddToPc {
        m: Reg,
    },

    Multiply {
        op: Multiply,
        d: Reg,
        n: Reg,
        m: Reg,
        a: Reg,
        set: Set,
    },
    LongMultiply {
        op: LongMultiply,
        low: Reg,
        high: Reg,
        n: Reg,
        m: Reg,
    },
    Divide {
        signed: bool,
        d: Reg,
        n: Reg,
        m: Reg,
    },

    /// n of 15 adds nothing.
    Extend {
        kind: Extend,
        d: Reg,
        n: Reg,
        m: Reg,
        rotate: u8,
    },
    Reverse {
        kind: Reverse,
        d: Reg,
        m: Reg,
    },
    /// n of 15 inserts zeros.
    Insert {
        d: Reg,
        n: Reg,
        lsb: u8,
        width: u8,
    },
    Extract {
        signed: bool,
        d: Reg,
        n: Reg,
        lsb: u8,
        width: u8,
    },
    Saturate {
        signed: bool,
        d: Reg,
        n: Reg,
        to: u8,
        shift: Shift,
        amount: u8,
    },
    SaturateHalves {
        signed: bool,
        d: Reg,
        n: Reg,
        to: u8,
    },
    SaturatingAdd {
        subtract: bool,
        double: bool,
        d: Reg,
        n: Reg,
        m: Reg,
    },
    Pack {
        top: bool,
        d: Reg,
        n: Reg,
        m: Reg,
        amount: u8,
    },
    Parallel {
        lanes: Lanes,
        op: Parallel,
        d: Reg,
        n: Reg,
        m: Reg,
    },
    Select {
        d: Reg,
        n: Reg,
        m: Reg,
    },

    Load {
        kind: Kind,
        t: Reg,
        n: Reg,
        index: Index,
        offset: i32,
    },
    LoadIndexed {
        kind: Kind,
        t: Reg,
        n: Reg,
        m: Reg,
        amount: u8,
    },
    LoadLiteral {
        kind: Kind,
        t: Reg,
        offset: i32,
    },
    Store {
        kind: Kind,
        t: Reg,
        n: Reg,
        index: Index,
        offset: i32,
    },
    StoreIndexed {
        kind: Kind,
        t: Reg,
        n: Reg,
        m: Reg,
        amount: u8,
    },
    LoadDual {
        t: Reg,
        t2: Reg,
        n: Reg,
        index: Index,
        offset: i32,
    },
    StoreDual {
        t: Reg,
        t2: Reg,
        n: Reg,
        index: Index,
        offset: i32,
    },
    LoadMultiple {
        n: Reg,
        before: bool,
        write_back: bool,
        list: u16,
    },
    StoreMultiple {
        n: Reg,
        before: bool,
        write_back: bool,
        list: u16,
    },
    LoadExclusive {
        kind: Kind,
        t: Reg,
        n: Reg,
        offset: i32,
    },
    StoreExclusive {
        kind: Kind,
        d: Reg,
        t: Reg,
        n: Reg,
        offset: i32,
    },
    ClearExclusive,
    TableBranch {
        n: Reg,
        m: Reg,
        half: bool,
    },

    Branch {
        offset: i32,
    },
    BranchIf {
        condition: u8,
        offset: i32,
    },
    BranchLink {
        offset: i32,
    },
    BranchExchange {
        m: Reg,
    },
    BranchLinkExchange {
        m: Reg,
    },
    CompareBranch {
        n: Reg,
        nonzero: bool,
        offset: i32,
    },
    IfThen {
        state: u8,
    },

    NoOperation,
    Barrier,
    WaitForEvent,
    WaitForInterrupt,
    SendEvent,
    Breakpoint {
        number: u8,
    },
    SupervisorCall,
    ChangeState {
        disable: bool,
        primask: bool,
        faultmask: bool,
    },
    ReadSpecial {
        d: Reg,
        special: u8,
    },
    WriteSpecial {
        n: Reg,
        special: u8,
        mask: u8,
    },

    Float {
        op: FloatOp,
        d: Reg,
        n: Reg,
        m: Reg,
    },
    FloatImmediate {
        d: Reg,
        bits: u32,
    },
    /// `with_zero`: m is not used.
    FloatCompare {
        d: Reg,
        m: Reg,
        with_zero: bool,
        signal: bool,
    },
    FloatConvert {
        op: Convert,
        d: Reg,
        m: Reg,
    },
    /// Between a core register and a single-precision one.
    FloatToCore {
        t: Reg,
        n: Reg,
    },
    CoreToFloat {
        t: Reg,
        n: Reg,
    },
    FloatPairToCore {
        t: Reg,
        t2: Reg,
        m: Reg,
    },
    CoreToFloatPair {
        t: Reg,
        t2: Reg,
        m: Reg,
    },
    /// 15 for t is the flags.
    ReadFloatStatus {
        t: Reg,
    },
    WriteFloatStatus {
        t: Reg,
    },
    /// Loads `count` registers from d on, of consecutive words.
    FloatLoad {
        d: Reg,
        count: u8,
        n: Reg,
        offset: i32,
    },
    FloatStore {
        d: Reg,
        count: u8,
        n: Reg,
        offset: i32,
    },
    FloatLoadMultiple {
        d: Reg,
        count: u8,
        n: Reg,
        before: bool,
        write_back: bool,
    },
    FloatStoreMultiple {
        d: Reg,
        count: u8,
        n: Reg,
        before: bool,
        write_back: bool,
    },
}
