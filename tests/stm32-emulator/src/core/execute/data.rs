//! Data processing of two operands, shifts, and the flags they set.
//! Source: DDI 0403, A4.4 and A7.7.

use super::super::Core;
use super::super::arithmetic::{Flags, add_with_carry, shift};
use super::super::instruction::{Operation, Reg, Set, Shift};
use super::is_comparison;

impl Core {
    /// Whether an instruction sets the flags here.
    #[inline]
    pub(super) fn sets(&self, set: Set) -> bool {
        match set {
            Set::Never => false,
            Set::Always => true,
            Set::OutsideIt => self.it == 0,
        }
    }

    /// An operation of n and another operand; `carry` is that of the operand's shift.
    #[inline]
    pub(super) fn operate(&mut self, op: Operation, set: Set, d: Reg, n: Reg, y: u32, carry: bool) {
        let x = self.get(n);
        let logical = |result| (result, carry, self.flags.v);
        let (result, c, v) = match op {
            Operation::And | Operation::Tst => logical(x & y),
            Operation::Bic => logical(x & !y),
            Operation::Orr => logical(x | y),
            Operation::Orn => logical(x | !y),
            Operation::Eor | Operation::Teq => logical(x ^ y),
            Operation::Mov => logical(y),
            Operation::Mvn => logical(!y),
            Operation::Add | Operation::Cmn => add_with_carry(x, y, false),
            Operation::Adc => add_with_carry(x, y, self.flags.c),
            Operation::Sub | Operation::Cmp => add_with_carry(x, !y, true),
            Operation::Sbc => add_with_carry(x, !y, self.flags.c),
            Operation::Rsb => add_with_carry(!x, y, true),
        };
        if self.sets(set) {
            self.flags = Flags {
                n: result >> 31 != 0,
                z: result == 0,
                c,
                v,
            };
        }
        if !is_comparison(op) {
            self.put(d, result);
        }
    }

    /// The same with a register, shifted by a constant.
    #[inline]
    pub(super) fn operate_shifted(
        &mut self,
        op: Operation,
        set: Set,
        [d, n, m]: [Reg; 3],
        kind: Shift,
        amount: u8,
    ) {
        let (mut y, mut carry) = (self.get(m), self.flags.c);
        if amount != 0 {
            (y, carry) = shift(y, kind, u32::from(amount), carry);
        }
        self.operate(op, set, d, n, y, carry);
    }

    /// A shift by the low byte of a register.
    #[inline]
    pub(super) fn shift_by(&mut self, kind: Shift, set: Set, d: Reg, n: Reg, m: Reg) {
        let amount = self.get(m) & 0xFF;
        let (result, c) = shift(self.get(n), kind, amount, self.flags.c);
        if self.sets(set) {
            self.set_nz(result);
            self.flags.c = c;
        }
        self.put(d, result);
    }

    pub(super) fn set_nz(&mut self, result: u32) {
        self.flags.n = result >> 31 != 0;
        self.flags.z = result == 0;
    }
}
