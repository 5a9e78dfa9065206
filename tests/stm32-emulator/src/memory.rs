//! The system's address space as the core accesses it: flash, SRAM and the peripherals.

/// Width of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Half,
    /// 32 bits.
    Word,
}

/// An address at which nothing answers, or that does not take this access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusError;

/// Address space of the chip without the core's private peripherals, which [`crate::core`] has
/// itself: `0xE000_0000` to `0xE003_FFFF`, and the ROM table at `0xE00F_F000`. What a chip adds
/// between them, such as an STM32's DBGMCU at `0xE004_2000`, is of this address space.
///
/// A failed read is a bus fault of its instruction. A failed write is one too, but an imprecise
/// one, after the instruction.
pub trait Memory {
    /// Reads; the value is zero-extended. Unaligned accesses of memory are allowed.
    ///
    /// # Errors
    /// [`BusError`] where nothing answers.
    fn read(&mut self, address: u32, width: Width) -> Result<u32, BusError>;

    /// Writes the low bits of `value`.
    ///
    /// # Errors
    /// [`BusError`] where nothing answers.
    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError>;

    /// Fetches a halfword of an instruction.
    ///
    /// # Errors
    /// [`BusError`] where there is no memory.
    fn fetch(&mut self, address: u32) -> Result<u16, BusError>;

    /// Called for each instruction before it is executed, be it fetched or kept decoded:
    /// to count stalls of the memory. `halfwords` is its length, 1 or 2.
    #[inline]
    fn executes(&mut self, address: u32, halfwords: u32) {
        let _ = (address, halfwords);
    }
}
