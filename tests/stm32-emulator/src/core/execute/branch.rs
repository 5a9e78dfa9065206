//! Branches. Source: DDI 0403, A4.3 and B1.4.7 (`BranchWritePC`, `BXWritePC`), B1.5.8.

use super::super::Core;
use super::super::cycles::REFILL;
use super::super::instruction::Reg;
use super::{Outcome, Stop};
use crate::memory::{Memory, Width};

impl Core {
    /// Branches relative to the program counter; the cycles of that.
    #[inline]
    pub(super) fn jump(&mut self, offset: i32) -> u32 {
        self.next = self.get(15).wrapping_add_signed(offset);
        REFILL
    }

    pub(super) fn jump_to(&mut self, target: u32) -> u32 {
        self.next = target & !1;
        REFILL
    }

    /// Branches as BX, POP and LDR do: in a handler it may be a return.
    #[inline]
    pub(super) fn branch_exchange(&mut self, target: u32) -> Outcome {
        if target >> 28 == 15 && self.exception != 0 {
            return Err(Stop::Return(target));
        }
        self.next = target & !1;
        if target & 1 == 0 {
            self.set_thumb(false);
        }
        Ok(REFILL)
    }

    pub(super) fn branch_link_exchange(&mut self, m: Reg) -> u32 {
        let target = self.get(m);
        self.r[14] = self.next | 1;
        self.next = target & !1;
        if target & 1 == 0 {
            self.set_thumb(false);
        }
        REFILL
    }

    pub(super) fn table_branch<M: Memory>(
        &mut self,
        memory: &mut M,
        n: Reg,
        m: Reg,
        half: bool,
    ) -> Outcome {
        let (places, width) = if half {
            (1, Width::Half)
        } else {
            (0, Width::Byte)
        };
        let address = self.get(n).wrapping_add(self.get(m) << places);
        let halfwords = self.load(memory, address, width)?;
        self.next = self.get(15).wrapping_add(halfwords * 2);
        Ok(REFILL)
    }
}
