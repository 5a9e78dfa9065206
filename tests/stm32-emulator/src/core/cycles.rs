//! Cycles of instructions and exceptions, without stalls of the memory.
//!
//! Source: "Cortex-M4 Technical Reference Manual" (ARM 100166), tables 3-1 (processor) and
//! 7-1 (floating point) and section 3.3.2 (pairing of loads). Where the tables give a range,
//! the model is said at the item. Folding of IT and out-of-order completion of integer
//! instructions after VDIV are not modelled.

use super::instruction::{FloatOp, Instruction};

/// P of the tables: the pipeline is filled anew, in 1 to 3 cycles.
pub(crate) const REFILL: u32 = 2;
/// Entry into an exception.
pub(crate) const ENTRY: u32 = 12;
/// Return from an exception.
pub(crate) const RETURN: u32 = 10;
/// From one exception to the next.
pub(crate) const TAIL_CHAIN: u32 = 6;

/// Cycles that are known when an instruction is decoded. Taken branches, divisions and waits
/// for a result add theirs when they are executed.
pub(crate) fn fixed(instruction: &Instruction) -> u8 {
    let list = |list: u16| 1 + list.count_ones() as u8;
    match *instruction {
        Instruction::Load { .. }
        | Instruction::LoadIndexed { .. }
        | Instruction::LoadLiteral { .. }
        | Instruction::LoadExclusive { .. }
        | Instruction::StoreIndexed { .. }
        | Instruction::StoreExclusive { .. }
        | Instruction::TableBranch { .. }
        | Instruction::FloatPairToCore { .. }
        | Instruction::CoreToFloatPair { .. } => 2,
        Instruction::LoadDual { .. } | Instruction::StoreDual { .. } => 3,
        Instruction::LoadMultiple { list: it, .. }
        | Instruction::StoreMultiple { list: it, .. } => list(it),
        Instruction::FloatLoad { count, .. }
        | Instruction::FloatStore { count, .. }
        | Instruction::FloatLoadMultiple { count, .. }
        | Instruction::FloatStoreMultiple { count, .. } => 1 + count,
        Instruction::Float { op, .. } => float(op),
        // With the write buffer a store takes one, as does everything else.
        _ => 1,
    }
}

fn float(op: FloatOp) -> u8 {
    match op {
        FloatOp::Divide | FloatOp::Root => 14,
        FloatOp::MultiplyAdd
        | FloatOp::MultiplySubtract
        | FloatOp::NegatedMultiplyAdd
        | FloatOp::NegatedMultiplySubtract
        | FloatOp::Fused
        | FloatOp::FusedSubtract
        | FloatOp::NegatedFused
        | FloatOp::NegatedFusedSubtract => 3,
        _ => 1,
    }
}

/// Whether it is a load that takes a cycle less behind another single access.
pub(crate) fn is_paired(instruction: &Instruction) -> bool {
    matches!(
        instruction,
        Instruction::Load { .. }
            | Instruction::LoadIndexed { .. }
            | Instruction::LoadLiteral { .. }
            | Instruction::StoreIndexed { .. }
    )
}

/// Whether it is a single access, behind which a load takes a cycle less.
pub(crate) fn is_access(instruction: &Instruction) -> bool {
    is_paired(instruction) || matches!(instruction, Instruction::Store { .. })
}

/// Cycles of a division beyond the first: 1 to 11, by the quotient's length, which is what is
/// left of the table's "depending on the leading digits".
pub(crate) fn division(dividend: u32, divisor: u32) -> u32 {
    if divisor == 0 || dividend < divisor {
        return 1;
    }
    let digits = divisor.leading_zeros() - dividend.leading_zeros() + 1;
    1 + (digits * 10).div_ceil(32)
}
