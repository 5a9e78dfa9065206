//! Accesses of data and fetches: alignment, MPU, bit-bands, private peripherals, memory.
//!
//! Flash and SRAM without MPU go straight to [`Memory`]. Failed reads are precise bus faults;
//! failed writes imprecise ones, after the instruction, as the write buffer makes them, unless
//! `ACTLR.DISDEFWBUF` is set. Source: DDI 0403, A3.2, B2.3.7 (order of checks), B3.1 (map);
//! 100166, 3.7.1 (bit-bands) and 2.3.2 (write buffer).

use super::Core;
use super::fault::Fault;
use super::mpu::{Access, is_executable};
use super::system_control::ccr;
use crate::memory::{Memory, Width};

/// Below are flash and SRAM, without aliases.
const DIRECT: u32 = 0x2200_0000;
const DISDEFWBUF: u32 = 1 << 1;

fn bytes(width: Width) -> u32 {
    match width {
        Width::Byte => 1,
        Width::Half => 2,
        Width::Word => 4,
    }
}

/// The core's own, without the parts of the private bus that a chip fills (`0xE004_2000`).
fn is_private(address: u32) -> bool {
    matches!(address, 0xE000_0000..=0xE003_FFFF | 0xE00F_F000..=0xE00F_FFFF)
}

impl Core {
    /// Reads; the value is zero-extended.
    #[inline]
    pub(crate) fn load<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
        width: Width,
    ) -> Result<u32, Fault> {
        if address < DIRECT && !self.checked {
            return match memory.read(address, width) {
                Ok(value) => Ok(value),
                Err(_) => self.failed_read(address),
            };
        }
        let privileged = self.is_privileged();
        self.load_checked(memory, address, width, privileged)
    }

    /// Writes the low bits.
    #[inline]
    pub(crate) fn store<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Fault> {
        if address < DIRECT && !self.checked {
            if memory.write(address, width, value).is_err() {
                return self.failed_write(address);
            }
            return Ok(());
        }
        let privileged = self.is_privileged();
        self.store_checked(memory, address, width, value, privileged)
    }

    /// Handlers at a priority below 0 may have bus faults ignored.
    fn ignores_faults(&self) -> bool {
        self.control.ccr & ccr::BFHFNMIGN != 0 && self.nvic.execution_priority() < 0
    }

    #[cold]
    fn failed_read(&self, address: u32) -> Result<u32, Fault> {
        if self.ignores_faults() {
            Ok(0)
        } else {
            Err(Fault::DataBus(address))
        }
    }

    #[cold]
    fn failed_write(&mut self, address: u32) -> Result<(), Fault> {
        if self.ignores_faults() {
            return Ok(());
        }
        if self.control.actlr & DISDEFWBUF != 0 || address >= 0xE000_0000 {
            return Err(Fault::DataBus(address));
        }
        self.fault_later();
        Ok(())
    }

    /// Whether the unit and the kind of memory let an access pass.
    fn check(
        &self,
        address: u32,
        width: Width,
        access: Access,
        privileged: bool,
    ) -> Result<(), Fault> {
        if address & (bytes(width) - 1) != 0 {
            // Devices and the private bus take no unaligned accesses.
            let is_device = matches!(address >> 29, 2 | 5 | 6 | 7);
            if is_device || self.control.ccr & ccr::UNALIGN_TRP != 0 {
                return Err(Fault::Unaligned);
            }
        }
        if self.mpu.is_enabled() {
            let negative = self.nvic.execution_priority() < 0;
            let last = address.wrapping_add(bytes(width) - 1);
            for byte in [address, last] {
                if !self.mpu.permits(byte, access, privileged, negative) {
                    return Err(Fault::DataAccess(byte));
                }
            }
        }
        Ok(())
    }

    /// A bit-band alias's byte or word, and the bit in it.
    fn bit_band(&self, address: u32) -> Option<(u32, u32)> {
        let is_alias = matches!(address >> 25, 0x11 | 0x21) && self.build.bit_band;
        let byte = (address & 0xF000_0000) + (address >> 5 & 0xF_FFFF);
        is_alias.then_some((byte & !3, (byte & 3) * 8 + (address >> 2 & 7)))
    }

    /// Reads with all checks.
    pub(crate) fn load_checked<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
        width: Width,
        privileged: bool,
    ) -> Result<u32, Fault> {
        self.check(address, width, Access::Read, privileged)?;
        let value = if is_private(address) {
            self.read_private(address, width, privileged)
        } else if let Some((word, bit)) = self.bit_band(address) {
            let value = memory.read(word, Width::Word);
            value.map(|value| value >> bit & 1)
        } else {
            memory.read(address, width)
        };
        value.or_else(|_| self.failed_read(address))
    }

    /// Writes with all checks; a failure on the bus is known at once or later.
    pub(crate) fn store_checked<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
        width: Width,
        value: u32,
        privileged: bool,
    ) -> Result<(), Fault> {
        match self.store_unbuffered(memory, address, width, value, privileged) {
            Err(Fault::DataBus(address)) => self.failed_write(address),
            result => result,
        }
    }

    /// Writes with all checks; a failure on the bus is known at once.
    pub(crate) fn store_unbuffered<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
        width: Width,
        value: u32,
        privileged: bool,
    ) -> Result<(), Fault> {
        self.check(address, width, Access::Write, privileged)?;
        let done = if is_private(address) {
            self.write_private(address, width, value, privileged)
        } else if let Some((word, bit)) = self.bit_band(address) {
            memory.read(word, Width::Word).and_then(|old| {
                let new = old & !(1 << bit) | (value & 1) << bit;
                memory.write(word, Width::Word, new)
            })
        } else {
            memory.write(address, width, value)
        };
        done.map_err(|_| Fault::DataBus(address))
    }

    /// Whether an instruction's halfword may be fetched; remembered for 32 bytes at a time,
    /// the least that the MPU distinguishes.
    pub(crate) fn check_fetch(&mut self, address: u32) -> Result<(), Fault> {
        if address >> 5 == self.fetch_granule {
            return Ok(());
        }
        let negative = self.nvic.execution_priority() < 0;
        let privileged = self.is_privileged();
        let allowed = if self.mpu.is_enabled() {
            self.mpu
                .permits(address, Access::Execute, privileged, negative)
        } else {
            is_executable(address)
        };
        if !allowed {
            return Err(Fault::FetchAccess);
        }
        self.fetch_granule = address >> 5;
        Ok(())
    }
}
