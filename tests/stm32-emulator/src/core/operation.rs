//! Operations, shifts and kinds of accesses that several instructions share.
//! Source: DDI 0403, A4 (overview) and A7.7.

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

/// Data type of a load or a store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Byte,
    Half,
    Word,
    SignedByte,
    SignedHalf,
}

/// Use of the base register of an access.
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

/// Treatment of the results of a parallel addition or subtraction.
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
