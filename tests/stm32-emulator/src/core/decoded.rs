//! The store of decoded instructions, by address.
//!
//! Instructions in [`super::Build::code`] are fetched and decoded once, and then kept until
//! [`Core::invalidate`]; all others each time.

use super::fault::Fault;
use super::instruction::Instruction;
use super::{Core, cycles, decode};
use crate::memory::Memory;

/// An instruction with what is known of it beforehand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decoded {
    pub(crate) instruction: Instruction,
    pub(crate) halfwords: u8,
    pub(crate) cycles: u8,
    pub(crate) is_paired: bool,
    pub(crate) is_access: bool,
}

impl Decoded {
    pub(crate) const UNKNOWN: Self = Self {
        instruction: Instruction::Unknown,
        halfwords: 0,
        cycles: 0,
        is_paired: false,
        is_access: false,
    };

    fn new(instruction: Instruction, halfwords: u8) -> Self {
        Self {
            instruction,
            halfwords,
            cycles: cycles::fixed(&instruction),
            is_paired: cycles::is_paired(&instruction),
            is_access: cycles::is_access(&instruction),
        }
    }

    /// Whether it is executed in an IT block whatever the condition.
    pub(crate) fn is_unconditional(&self) -> bool {
        matches!(self.instruction, Instruction::Breakpoint { .. })
    }
}

impl Core {
    /// Place of the instruction at an address in the store; its last place is for those that
    /// are not kept.
    #[inline]
    pub(super) fn fetch<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
    ) -> Result<usize, Fault> {
        let place = address.wrapping_sub(self.build.code.start) as usize / 2;
        if place < self.decoded.len() - 1
            && !matches!(self.decoded[place].instruction, Instruction::Unknown)
            && (!self.mpu.is_enabled() || self.is_checked(address))
        {
            return Ok(place);
        }
        self.fetch_anew(memory, address)
    }

    /// Whether the instruction lies within the 32 bytes that were checked.
    fn is_checked(&self, address: u32) -> bool {
        address >> 5 == self.fetch_granule && address & 0x1E != 0x1E
    }

    #[inline(never)]
    fn fetch_anew<M: Memory>(&mut self, memory: &mut M, address: u32) -> Result<usize, Fault> {
        self.check_fetch(address)?;
        let first = memory.fetch(address).map_err(|_| Fault::FetchBus)?;
        let decoded = if decode::is_wide(first) {
            let behind = address.wrapping_add(2);
            self.check_fetch(behind)?;
            let second = memory.fetch(behind).map_err(|_| Fault::FetchBus)?;
            Decoded::new(decode::wide(first, second), 2)
        } else {
            Decoded::new(decode::narrow(first), 1)
        };
        let place = address.wrapping_sub(self.build.code.start) as usize / 2;
        let place = place.min(self.decoded.len() - 1);
        self.decoded[place] = decoded;
        Ok(place)
    }

    /// Forgets decoded instructions, after the memory of [`super::Build::code`] changed.
    pub fn invalidate(&mut self) {
        self.decoded.fill(Decoded::UNKNOWN);
    }
}

/// The code at an address, as [`super::Step::Unimplemented`] gives it.
pub(super) fn opcode<M: Memory>(memory: &mut M, address: u32) -> u32 {
    let first = memory.fetch(address).unwrap_or(0);
    if decode::is_wide(first) {
        let second = memory.fetch(address.wrapping_add(2)).unwrap_or(0);
        u32::from(first) << 16 | u32::from(second)
    } else {
        u32::from(first)
    }
}
