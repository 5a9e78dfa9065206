//! Single loads and stores, pairs, and exclusives. Source: DDI 0403, A4.6, A3.4 (exclusives).
//!
//! A base register changes only after the access succeeded.

use super::super::Core;
use super::super::fault::Fault;
use super::super::instruction::{Index, Kind, Reg};
use super::Outcome;
use crate::memory::{Memory, Width};

/// Width of what is moved.
#[inline]
pub(super) fn width(kind: Kind) -> Width {
    match kind {
        Kind::Byte | Kind::SignedByte => Width::Byte,
        Kind::Half | Kind::SignedHalf => Width::Half,
        Kind::Word => Width::Word,
    }
}

#[inline]
fn extend(kind: Kind, value: u32) -> u32 {
    match kind {
        Kind::SignedByte => value as i8 as u32,
        Kind::SignedHalf => value as i16 as u32,
        _ => value,
    }
}

/// Words and dwords of exclusives, LDRD and LDM have to be aligned.
pub(super) fn aligned(address: u32, width: Width) -> Result<(), Fault> {
    let mask = match width {
        Width::Byte => 0,
        Width::Half => 1,
        Width::Word => 3,
    };
    if address & mask == 0 {
        Ok(())
    } else {
        Err(Fault::Unaligned)
    }
}

impl Core {
    /// The address of an access, and what its base becomes.
    #[inline]
    fn indexed(&self, n: Reg, index: Index, offset: i32) -> (u32, Option<u32>) {
        let base = self.get(n);
        let moved = base.wrapping_add_signed(offset);
        match index {
            Index::Offset | Index::Unprivileged => (moved, None),
            Index::Pre => (moved, Some(moved)),
            Index::Post => (base, Some(moved)),
        }
    }

    /// Loads into a register, or branches.
    #[inline]
    pub(super) fn load_into<M: Memory>(
        &mut self,
        memory: &mut M,
        kind: Kind,
        t: Reg,
        address: u32,
    ) -> Outcome {
        let value = self.load(memory, address, width(kind))?;
        if t == 15 {
            return self.branch_exchange(value);
        }
        self.put(t, extend(kind, value));
        Ok(0)
    }

    #[inline]
    pub(super) fn execute_load<M: Memory>(
        &mut self,
        memory: &mut M,
        kind: Kind,
        t: Reg,
        n: Reg,
        index: Index,
        offset: i32,
    ) -> Outcome {
        let (address, base) = self.indexed(n, index, offset);
        let value = if index == Index::Unprivileged {
            self.load_checked(memory, address, width(kind), false)?
        } else {
            self.load(memory, address, width(kind))?
        };
        if let Some(base) = base {
            self.put(n, base);
        }
        if t == 15 {
            return self.branch_exchange(value);
        }
        self.put(t, extend(kind, value));
        Ok(0)
    }

    #[inline]
    pub(super) fn execute_store<M: Memory>(
        &mut self,
        memory: &mut M,
        kind: Kind,
        t: Reg,
        n: Reg,
        index: Index,
        offset: i32,
    ) -> Outcome {
        let (address, base) = self.indexed(n, index, offset);
        let value = self.get(t);
        if index == Index::Unprivileged {
            self.store_checked(memory, address, width(kind), value, false)?;
        } else {
            self.store(memory, address, width(kind), value)?;
        }
        if let Some(base) = base {
            self.put(n, base);
        }
        Ok(0)
    }

    /// The base of pairs is the word of the program counter for literals.
    fn dual_base(&self, n: Reg, index: Index, offset: i32) -> (u32, Option<u32>) {
        if n == 15 {
            ((self.get(15) & !3).wrapping_add_signed(offset), None)
        } else {
            self.indexed(n, index, offset)
        }
    }

    pub(super) fn load_dual<M: Memory>(
        &mut self,
        memory: &mut M,
        [t, t2, n]: [Reg; 3],
        index: Index,
        offset: i32,
    ) -> Outcome {
        let (address, base) = self.dual_base(n, index, offset);
        aligned(address, Width::Word)?;
        let low = self.load(memory, address, Width::Word)?;
        let high = self.load(memory, address.wrapping_add(4), Width::Word)?;
        self.put(t, low);
        self.put(t2, high);
        if let Some(base) = base {
            self.put(n, base);
        }
        Ok(0)
    }

    pub(super) fn store_dual<M: Memory>(
        &mut self,
        memory: &mut M,
        [t, t2, n]: [Reg; 3],
        index: Index,
        offset: i32,
    ) -> Outcome {
        let (address, base) = self.dual_base(n, index, offset);
        aligned(address, Width::Word)?;
        self.store(memory, address, Width::Word, self.get(t))?;
        let second = address.wrapping_add(4);
        self.store(memory, second, Width::Word, self.get(t2))?;
        if let Some(base) = base {
            self.put(n, base);
        }
        Ok(0)
    }

    pub(super) fn load_exclusive<M: Memory>(
        &mut self,
        memory: &mut M,
        kind: Kind,
        t: Reg,
        n: Reg,
        offset: i32,
    ) -> Outcome {
        let address = self.get(n).wrapping_add_signed(offset);
        aligned(address, width(kind))?;
        let value = self.load(memory, address, width(kind))?;
        self.exclusive = true;
        self.put(t, value);
        Ok(0)
    }

    pub(super) fn store_exclusive<M: Memory>(
        &mut self,
        memory: &mut M,
        kind: Kind,
        [d, t, n]: [Reg; 3],
        offset: i32,
    ) -> Outcome {
        let address = self.get(n).wrapping_add_signed(offset);
        aligned(address, width(kind))?;
        // The local monitor does not compare addresses.
        let succeeds = self.exclusive;
        if succeeds {
            self.store(memory, address, width(kind), self.get(t))?;
            self.exclusive = false;
        }
        self.put(d, u32::from(!succeeds));
        Ok(0)
    }
}
