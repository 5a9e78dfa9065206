//! Execution of decoded instructions.
//!
//! Each method changes the core as the pseudocode of the instruction says and returns the
//! cycles beyond the fixed ones, or why it stopped. Source: DDI 0403, A7.7.

mod branch;
mod data;
mod float;
mod float_memory;
mod memory;
mod multiple;
mod multiply;
mod simd;
mod system;

use super::Core;
use super::fault::Fault;
use super::instruction::{Instruction, Operation};
use crate::memory::Memory;

/// Why the processor does not go on with the next instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stop {
    /// The instruction was not executed.
    Fault(Fault),
    /// It was, and returns from an exception.
    Return(u32),
    /// It is a breakpoint.
    Breakpoint(u8),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// Cycles beyond the fixed ones.
pub(crate) type Outcome = Result<u32, Stop>;

impl Core {
    /// Executes the instruction at a place of the store; [`Core::next`] is the address behind it,
    /// and where it branches.
    #[inline]
    #[expect(clippy::too_many_lines, reason = "a table of instructions")]
    pub(crate) fn execute<M: Memory>(&mut self, memory: &mut M, place: usize) -> Outcome {
        // Only the fields are copied.
        match self.decoded[place].instruction {
            Instruction::Immediate {
                op,
                set,
                d,
                n,
                rotated,
                value,
            } => {
                let carry = if rotated {
                    value >> 31 != 0
                } else {
                    self.flags.c
                };
                self.operate(op, set, d, n, value, carry);
            }
            Instruction::Register {
                op,
                set,
                d,
                n,
                m,
                shift,
                amount,
            } => self.operate_shifted(op, set, [d, n, m], shift, amount),
            Instruction::ShiftBy {
                shift,
                set,
                d,
                n,
                m,
            } => self.shift_by(shift, set, d, n, m),
            Instruction::MoveTop { d, value } => {
                let low = self.get(d) & 0xFFFF;
                self.put(d, u32::from(value) << 16 | low);
            }
            Instruction::Address { d, offset } => {
                let address = (self.get(15) & !3).wrapping_add_signed(offset);
                self.put(d, address);
            }
            Instruction::Load {
                kind,
                t,
                n,
                index,
                offset,
            } => return self.execute_load(memory, kind, t, n, index, offset),
            Instruction::Store {
                kind,
                t,
                n,
                index,
                offset,
            } => return self.execute_store(memory, kind, t, n, index, offset),
            Instruction::LoadIndexed {
                kind,
                t,
                n,
                m,
                amount,
            } => {
                let address = self.get(n).wrapping_add(self.get(m) << amount);
                return self.load_into(memory, kind, t, address);
            }
            Instruction::StoreIndexed {
                kind,
                t,
                n,
                m,
                amount,
            } => {
                let address = self.get(n).wrapping_add(self.get(m) << amount);
                self.store(memory, address, memory::width(kind), self.get(t))?;
            }
            Instruction::LoadLiteral { kind, t, offset } => {
                let address = (self.get(15) & !3).wrapping_add_signed(offset);
                return self.load_into(memory, kind, t, address);
            }
            Instruction::LoadMultiple {
                n,
                before,
                write_back,
                list,
            } => return self.load_multiple(memory, n, before, write_back, list),
            Instruction::StoreMultiple {
                n,
                before,
                write_back,
                list,
            } => return self.store_multiple(memory, n, before, write_back, list),
            Instruction::LoadDual {
                t,
                t2,
                n,
                index,
                offset,
            } => return self.load_dual(memory, [t, t2, n], index, offset),
            Instruction::StoreDual {
                t,
                t2,
                n,
                index,
                offset,
            } => return self.store_dual(memory, [t, t2, n], index, offset),
            Instruction::Branch { offset } => return Ok(self.jump(offset)),
            Instruction::BranchIf { condition, offset } => {
                if self.flags.hold(condition) {
                    return Ok(self.jump(offset));
                }
            }
            Instruction::CompareBranch { n, nonzero, offset } => {
                if (self.get(n) != 0) == nonzero {
                    return Ok(self.jump(offset));
                }
            }
            Instruction::BranchLink { offset } => {
                self.r[14] = self.next | 1;
                return Ok(self.jump(offset));
            }
            Instruction::BranchExchange { m } => return self.branch_exchange(self.get(m)),
            Instruction::IfThen { state } => self.it = state,
            Instruction::Float { op, d, n, m } => return self.float_operate(memory, op, d, n, m),
            Instruction::FloatLoad {
                d,
                count,
                n,
                offset,
            } => return self.float_load(memory, d, count, n, offset),
            Instruction::FloatStore {
                d,
                count,
                n,
                offset,
            } => return self.float_store(memory, d, count, n, offset),
            other => return self.execute_other(memory, other),
        }
        Ok(0)
    }

    /// The less frequent ones.
    #[inline(never)]
    fn execute_other<M: Memory>(&mut self, memory: &mut M, instruction: Instruction) -> Outcome {
        match instruction {
            Instruction::Multiply {
                op,
                d,
                n,
                m,
                a,
                set,
            } => self.multiply(op, [d, n, m, a], set),
            Instruction::LongMultiply {
                op,
                low,
                high,
                n,
                m,
            } => self.long_multiply(op, [low, high, n, m]),
            Instruction::Divide { signed, d, n, m } => return self.divide(signed, d, n, m),
            Instruction::Extend {
                kind,
                d,
                n,
                m,
                rotate,
            } => self.extend(kind, d, n, m, rotate),
            Instruction::Reverse { kind, d, m } => self.reverse(kind, d, m),
            Instruction::Insert { d, n, lsb, width } => self.insert(d, n, lsb, width),
            Instruction::Extract {
                signed,
                d,
                n,
                lsb,
                width,
            } => self.extract(signed, d, n, lsb, width),
            Instruction::Saturate {
                signed,
                d,
                n,
                to,
                shift,
                amount,
            } => self.saturate(signed, d, n, to, (shift, amount)),
            Instruction::SaturateHalves { signed, d, n, to } => {
                self.saturate_halves(signed, d, n, to);
            }
            Instruction::SaturatingAdd {
                subtract,
                double,
                d,
                n,
                m,
            } => self.saturating_add(subtract, double, d, n, m),
            Instruction::Pack {
                top,
                d,
                n,
                m,
                amount,
            } => self.pack(top, d, n, m, amount),
            Instruction::Parallel { lanes, op, d, n, m } => self.parallel(lanes, op, d, n, m),
            Instruction::Select { d, n, m } => self.select(d, n, m),
            Instruction::MoveToPc { m } => return Ok(self.jump_to(self.get(m))),
            Instruction::AddToPc { m } => {
                let target = self.get(15).wrapping_add(self.get(m));
                return Ok(self.jump_to(target));
            }
            Instruction::BranchLinkExchange { m } => return Ok(self.branch_link_exchange(m)),
            Instruction::TableBranch { n, m, half } => {
                return self.table_branch(memory, n, m, half);
            }
            Instruction::LoadExclusive { kind, t, n, offset } => {
                return self.load_exclusive(memory, kind, t, n, offset);
            }
            Instruction::StoreExclusive {
                kind,
                d,
                t,
                n,
                offset,
            } => return self.store_exclusive(memory, kind, [d, t, n], offset),
            other => return self.execute_system(memory, other),
        }
        Ok(0)
    }
}

/// Whether the operation only compares.
fn is_comparison(op: Operation) -> bool {
    use Operation::{Cmn, Cmp, Teq, Tst};
    matches!(op, Tst | Teq | Cmp | Cmn)
}
