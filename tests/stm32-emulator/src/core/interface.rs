//! Inputs of the processor, and results of a step.

use std::ops::Range;

/// Options that the processor leaves to the chip, as chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Build {
    /// Number of interrupts, at most 240.
    pub interrupts: u16,
    /// Implemented bits of a priority, 3 to 8: 4 for an STM32.
    pub priority_bits: u8,
    /// Address of the vector table at reset.
    pub vectors: u32,
    /// Addresses of which decoded instructions are kept until [`Core::invalidate`](super::Core::invalidate): memory
    /// that programs do not write.
    pub code: Range<u32>,
    /// Whether a debugger halts at BKPT ([`Step::Breakpoint`]); otherwise it is a fault.
    pub debugger: bool,
    /// Whether the bit-band aliases exist.
    pub bit_band: bool,
}

/// State in which a program starts other than by a reset, as a ROM boot loader leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// Main stack pointer.
    pub sp: u32,
    /// Address of the first instruction; bit 0 is ignored.
    pub pc: u32,
    /// Vector table offset register.
    pub vtor: u32,
    /// Whether exceptions of settable priority are masked.
    pub primask: bool,
}

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One instruction was executed.
    Executed {
        /// Cycles it took, without stalls of the memory.
        cycles: u32,
    },
    /// An exception was entered; no instruction was executed.
    Entered {
        /// Its number: 16 is interrupt 0.
        exception: u16,
        /// Cycles it took, without stalls of the memory.
        cycles: u32,
    },
    /// The processor sleeps, and nothing wakes it yet.
    Sleeping,
    /// The program requested a reset (`AIRCR.SYSRESETREQ`); the next step goes on without one.
    ResetRequested,
    /// BKPT with this number; the program counter is behind it.
    Breakpoint(u8),
    /// The emulator lacks this instruction; it was a usage fault (UNDEFINSTR).
    Unimplemented {
        /// Address of the instruction.
        pc: u32,
        /// Its first halfword in bits 31 to 16 if it has two, its only one in bits 15 to 0.
        opcode: u32,
    },
    /// The processor is locked up at this instruction, until a reset.
    Lockup {
        /// Address of the instruction.
        pc: u32,
    },
}

impl Step {
    /// Cycles of the step, without stalls of the memory.
    pub fn cycles(self) -> u32 {
        match self {
            Self::Executed { cycles } | Self::Entered { cycles, .. } => cycles,
            _ => 1,
        }
    }
}
