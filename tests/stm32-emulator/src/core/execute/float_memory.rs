//! Loads and stores of floating-point registers. Source: DDI 0403, A6.5 and A7.7 (VLDR, VLDM).
//!
//! Registers change only after all accesses succeeded.

use super::super::Core;
use super::super::instruction::Reg;
use super::Outcome;
use super::memory::aligned;
use crate::memory::{Memory, Width};

impl Core {
    fn float_base(&self, n: Reg) -> u32 {
        let base = self.get(n);
        if n == 15 { base & !3 } else { base }
    }

    #[inline]
    pub(super) fn float_load<M: Memory>(
        &mut self,
        memory: &mut M,
        d: Reg,
        count: u8,
        n: Reg,
        offset: i32,
    ) -> Outcome {
        self.use_float(memory)?;
        let address = self.float_base(n).wrapping_add_signed(offset);
        aligned(address, Width::Word)?;
        let first = self.load(memory, address, Width::Word)?;
        if count == 2 {
            let second = self.load(memory, address.wrapping_add(4), Width::Word)?;
            self.s[usize::from((d + 1) & 31)] = second;
        }
        self.s[usize::from(d & 31)] = first;
        Ok(0)
    }

    #[inline]
    pub(super) fn float_store<M: Memory>(
        &mut self,
        memory: &mut M,
        d: Reg,
        count: u8,
        n: Reg,
        offset: i32,
    ) -> Outcome {
        self.use_float(memory)?;
        let wait = self.wait_for(d);
        let mut address = self.float_base(n).wrapping_add_signed(offset);
        aligned(address, Width::Word)?;
        for register in d..d + count {
            let value = self.s[usize::from(register & 31)];
            self.store(memory, address, Width::Word, value)?;
            address = address.wrapping_add(4);
        }
        Ok(wait)
    }

    pub(super) fn float_load_multiple<M: Memory>(
        &mut self,
        memory: &mut M,
        (d, count): (Reg, u8),
        n: Reg,
        before: bool,
        write_back: bool,
    ) -> Outcome {
        let (mut address, base) = self.block(n, before, count.into());
        aligned(address, Width::Word)?;
        let mut values = [0; 32];
        for value in &mut values[..usize::from(count.min(32))] {
            *value = self.load(memory, address, Width::Word)?;
            address = address.wrapping_add(4);
        }
        let (first, count) = (usize::from(d), usize::from(count));
        self.s[first..first + count].copy_from_slice(&values[..count]);
        if write_back {
            self.put(n, base);
        }
        Ok(0)
    }

    pub(super) fn float_store_multiple<M: Memory>(
        &mut self,
        memory: &mut M,
        (d, count): (Reg, u8),
        n: Reg,
        before: bool,
        write_back: bool,
    ) -> Outcome {
        let (mut address, base) = self.block(n, before, count.into());
        aligned(address, Width::Word)?;
        for register in d..d + count {
            let value = self.s[usize::from(register & 31)];
            self.store(memory, address, Width::Word, value)?;
            address = address.wrapping_add(4);
        }
        if write_back {
            self.put(n, base);
        }
        Ok(0)
    }
}
