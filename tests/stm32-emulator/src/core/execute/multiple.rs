//! Loads and stores of several registers. Source: DDI 0403, A4.7 and A7.7 (LDM, STM, PUSH, POP).
//!
//! Registers change only after all accesses succeeded, so that an instruction that faulted
//! can be executed again.

use super::super::Core;
use super::super::instruction::Reg;
use super::Outcome;
use super::memory::aligned;
use crate::memory::{Memory, Width};

/// Registers of a list, lowest first.
fn registers(list: u16) -> impl Iterator<Item = Reg> {
    let mut rest = list;
    std::iter::from_fn(move || {
        let register = rest.trailing_zeros();
        rest &= rest.wrapping_sub(1);
        (register < 16).then_some(register as Reg)
    })
}

impl Core {
    /// Lowest address of this many words at a base, and what the base becomes.
    pub(super) fn block(&self, n: Reg, before: bool, words: u32) -> (u32, u32) {
        let (base, size) = (self.get(n), 4 * words);
        if before {
            let start = base.wrapping_sub(size);
            (start, start)
        } else {
            (base, base.wrapping_add(size))
        }
    }

    pub(super) fn load_multiple<M: Memory>(
        &mut self,
        memory: &mut M,
        n: Reg,
        before: bool,
        write_back: bool,
        list: u16,
    ) -> Outcome {
        let (mut address, base) = self.block(n, before, list.count_ones());
        aligned(address, Width::Word)?;
        let mut values = [0; 16];
        for register in registers(list) {
            values[usize::from(register & 15)] = self.load(memory, address, Width::Word)?;
            address = address.wrapping_add(4);
        }
        for register in registers(list & 0x7FFF) {
            self.put(register, values[usize::from(register & 15)]);
        }
        if write_back {
            self.put(n, base);
        }
        if list >> 15 != 0 {
            return self.branch_exchange(values[15]);
        }
        Ok(0)
    }

    pub(super) fn store_multiple<M: Memory>(
        &mut self,
        memory: &mut M,
        n: Reg,
        before: bool,
        write_back: bool,
        list: u16,
    ) -> Outcome {
        let (mut address, base) = self.block(n, before, list.count_ones());
        aligned(address, Width::Word)?;
        for register in registers(list) {
            self.store(memory, address, Width::Word, self.get(register))?;
            address = address.wrapping_add(4);
        }
        if write_back {
            self.put(n, base);
        }
        Ok(0)
    }
}
