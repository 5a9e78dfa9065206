//! Faults: what an instruction could not do, and what becomes of it.
//!
//! A fault sets its bit in CFSR and the address where there is one, and makes its exception
//! pending, or `HardFault` if that may not be entered; in `HardFault` and NMI it is a lockup.
//! Source: DDI 0403, B1.5.14, B1.5.15 and B3.2.15.

use super::nvic::number;
use super::{Core, State};

/// Bits of CFSR.
pub(crate) mod cfsr {
    pub(crate) const IACCVIOL: u32 = 1 << 0;
    pub(crate) const DACCVIOL: u32 = 1 << 1;
    pub(crate) const MUNSTKERR: u32 = 1 << 3;
    pub(crate) const MSTKERR: u32 = 1 << 4;
    pub(crate) const MLSPERR: u32 = 1 << 5;
    pub(crate) const MMARVALID: u32 = 1 << 7;
    pub(crate) const IBUSERR: u32 = 1 << 8;
    pub(crate) const PRECISERR: u32 = 1 << 9;
    pub(crate) const IMPRECISERR: u32 = 1 << 10;
    pub(crate) const UNSTKERR: u32 = 1 << 11;
    pub(crate) const STKERR: u32 = 1 << 12;
    pub(crate) const LSPERR: u32 = 1 << 13;
    pub(crate) const BFARVALID: u32 = 1 << 15;
    pub(crate) const UNDEFINSTR: u32 = 1 << 16;
    pub(crate) const INVSTATE: u32 = 1 << 17;
    pub(crate) const INVPC: u32 = 1 << 18;
    pub(crate) const NOCP: u32 = 1 << 19;
    pub(crate) const UNALIGNED: u32 = 1 << 24;
    pub(crate) const DIVBYZERO: u32 = 1 << 25;
}

/// Bits of HFSR.
pub(crate) mod hfsr {
    pub(crate) const VECTTBL: u32 = 1 << 1;
    pub(crate) const FORCED: u32 = 1 << 30;
    pub(crate) const DEBUGEVT: u32 = 1 << 31;
}

/// Why an instruction was not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    Undefined,
    /// Not in this emulator.
    Unimplemented,
    InvalidState,
    InvalidPc,
    NoCoprocessor,
    Unaligned,
    DivideByZero,
    /// Nothing answered a fetch.
    FetchBus,
    /// Nothing answered a read of this address, or a write that is not buffered.
    DataBus(u32),
    /// The MPU, or the default map, forbids to execute.
    FetchAccess,
    /// The MPU forbids an access of this address.
    DataAccess(u32),
}

impl Fault {
    /// Its bits of CFSR, its exception, and its address.
    pub(crate) fn parts(self) -> (u32, u16, Option<u32>) {
        use number::{BUS_FAULT, MEMORY_FAULT, USAGE_FAULT};
        match self {
            Self::Undefined | Self::Unimplemented => (cfsr::UNDEFINSTR, USAGE_FAULT, None),
            Self::InvalidState => (cfsr::INVSTATE, USAGE_FAULT, None),
            Self::InvalidPc => (cfsr::INVPC, USAGE_FAULT, None),
            Self::NoCoprocessor => (cfsr::NOCP, USAGE_FAULT, None),
            Self::Unaligned => (cfsr::UNALIGNED, USAGE_FAULT, None),
            Self::DivideByZero => (cfsr::DIVBYZERO, USAGE_FAULT, None),
            Self::FetchBus => (cfsr::IBUSERR, BUS_FAULT, None),
            Self::DataBus(address) => (cfsr::PRECISERR, BUS_FAULT, Some(address)),
            Self::FetchAccess => (cfsr::IACCVIOL, MEMORY_FAULT, None),
            Self::DataAccess(address) => (cfsr::DACCVIOL, MEMORY_FAULT, Some(address)),
        }
    }

    /// Whether it is a matter of the MPU.
    pub(crate) fn is_access(self) -> bool {
        matches!(self, Self::FetchAccess | Self::DataAccess(_))
    }
}

impl Core {
    /// An instruction faulted: its exception is pending, or the processor locked up.
    pub(crate) fn fault(&mut self, fault: Fault) {
        let (bits, exception, address) = fault.parts();
        self.control.cfsr |= bits;
        match (fault, address) {
            (Fault::DataBus(_), Some(address)) => {
                self.control.cfsr |= cfsr::BFARVALID;
                self.control.bfar = address;
            }
            (_, Some(address)) => {
                self.control.cfsr |= cfsr::MMARVALID;
                self.control.mmfar = address;
            }
            _ => {}
        }
        self.raise(exception);
    }

    /// Makes the exception of an instruction pending, or `HardFault` instead of it.
    pub(crate) fn raise(&mut self, exception: u16) {
        if self.nvic.can_preempt(exception) {
            self.nvic.pend(exception);
        } else if self.nvic.execution_priority() < 0 {
            self.lock_up();
        } else {
            self.control.hfsr |= hfsr::FORCED;
            self.nvic.pend(number::HARD_FAULT);
        }
    }

    /// A buffered write failed: an exception at any later time.
    pub(crate) fn fault_later(&mut self) {
        self.control.cfsr |= cfsr::IMPRECISERR;
        if self.nvic.is_enabled(number::BUS_FAULT) {
            self.nvic.pend(number::BUS_FAULT);
        } else {
            self.control.hfsr |= hfsr::FORCED;
            self.nvic.pend(number::HARD_FAULT);
        }
    }

    /// Stops the processor until a reset or an NMI.
    pub(crate) fn lock_up(&mut self) {
        self.state = State::LockedUp;
    }
}
