//! Registers of system control and of the floating-point unit's control.
//!
//! Source: DDI 0403, B3.2; 100166, 4.1 for the values at reset.

use super::nvic::number;
use super::{Core, State};

/// Cortex-M4 r0p1.
const CPUID: u32 = 0x410F_C241;
const AIRCR_KEY: u32 = 0x05FA;
const CCR_WRITABLE: u32 = 0x31B;
/// Bits of SHCSR that say which faults are active, by exception.
const ACTIVE_BITS: [(u32, u16); 7] = [(0, 4), (1, 5), (3, 6), (7, 11), (8, 12), (10, 14), (11, 15)];
/// Bits of SHCSR that say which are pending.
const PENDING_BITS: [(u32, u16); 4] = [(12, 6), (13, 4), (14, 5), (15, 11)];
/// Bits of SHCSR that enable.
const ENABLE_BITS: [(u32, u16); 3] = [(16, 4), (17, 5), (18, 6)];

/// Registers without a unit of their own.
#[derive(Clone, Debug)]
pub(crate) struct SystemControl {
    pub(crate) vtor: u32,
    pub(crate) prigroup: u32,
    pub(crate) scr: u32,
    pub(crate) ccr: u32,
    pub(crate) cfsr: u32,
    pub(crate) hfsr: u32,
    pub(crate) dfsr: u32,
    pub(crate) mmfar: u32,
    pub(crate) bfar: u32,
    pub(crate) cpacr: u32,
    pub(crate) fpccr: u32,
    pub(crate) fpcar: u32,
    pub(crate) fpdscr: u32,
    pub(crate) actlr: u32,
}

impl SystemControl {
    pub(crate) fn new(vtor: u32) -> Self {
        Self {
            vtor,
            prigroup: 0,
            scr: 0,
            ccr: ccr::STKALIGN,
            cfsr: 0,
            hfsr: 0,
            dfsr: 0,
            mmfar: 0,
            bfar: 0,
            cpacr: 0,
            fpccr: fpccr::ASPEN | fpccr::LSPEN,
            fpcar: 0,
            fpdscr: 0,
            actlr: 0,
        }
    }
}

/// Bits of CCR.
pub(crate) mod ccr {
    pub(crate) const NONBASETHRDENA: u32 = 1 << 0;
    pub(crate) const USERSETMPEND: u32 = 1 << 1;
    pub(crate) const UNALIGN_TRP: u32 = 1 << 3;
    pub(crate) const DIV_0_TRP: u32 = 1 << 4;
    pub(crate) const BFHFNMIGN: u32 = 1 << 8;
    pub(crate) const STKALIGN: u32 = 1 << 9;
}

/// Bits of FPCCR.
pub(crate) mod fpccr {
    pub(crate) const LSPACT: u32 = 1 << 0;
    pub(crate) const USER: u32 = 1 << 1;
    pub(crate) const THREAD: u32 = 1 << 3;
    pub(crate) const HFRDY: u32 = 1 << 4;
    pub(crate) const MMRDY: u32 = 1 << 5;
    pub(crate) const BFRDY: u32 = 1 << 6;
    pub(crate) const MONRDY: u32 = 1 << 8;
    pub(crate) const LSPEN: u32 = 1 << 30;
    pub(crate) const ASPEN: u32 = 1 << 31;
}

/// `SCR.SLEEPONEXIT`.
pub(crate) const SCR_SLEEPONEXIT: u32 = 1 << 1;
const SCR_SEVONPEND: u32 = 1 << 4;

impl Core {
    /// Reads a register of system control.
    pub(crate) fn read_control(&self, address: u32) -> u32 {
        let control = &self.control;
        match address {
            0xE000_ED00 => CPUID,
            0xE000_ED04 => self.read_icsr(),
            0xE000_ED08 => control.vtor,
            0xE000_ED0C => 0xFA05 << 16 | control.prigroup << 8,
            0xE000_ED10 => control.scr,
            0xE000_ED14 => control.ccr,
            0xE000_ED24 => {
                let bits = |table: &[(u32, u16)], is: &dyn Fn(u16) -> bool| {
                    let set = table.iter().filter(|(_, exception)| is(*exception));
                    set.fold(0, |value, (bit, _)| value | 1 << bit)
                };
                bits(&ACTIVE_BITS, &|exception| self.nvic.is_active(exception))
                    | bits(&PENDING_BITS, &|exception| self.nvic.is_pending(exception))
                    | bits(&ENABLE_BITS, &|exception| self.nvic.is_enabled(exception))
            }
            0xE000_ED28 => control.cfsr,
            0xE000_ED2C => control.hfsr,
            0xE000_ED30 => control.dfsr,
            0xE000_ED34 => control.mmfar,
            0xE000_ED38 => control.bfar,
            0xE000_ED88 => control.cpacr,
            0xE000_EDF0 => u32::from(self.build.debugger),
            0xE000_EDFC => self.debug.demcr,
            0xE000_EF34 => control.fpccr,
            0xE000_EF38 => control.fpcar,
            0xE000_EF3C => control.fpdscr,
            0xE000_EF40 => 0x1011_0021,
            0xE000_EF44 => 0x1100_0011,
            _ => 0,
        }
    }

    fn read_icsr(&self) -> u32 {
        let pending = |exception, bit: u32| u32::from(self.nvic.is_pending(exception)) << bit;
        let interrupts = number::INTERRUPT_0..=self.nvic.last();
        let any = interrupts
            .into_iter()
            .any(|exception| self.nvic.is_pending(exception));
        let alone = self.nvic.active_count() <= 1;
        pending(number::NMI, 31)
            | pending(number::PEND_SUPERVISOR, 28)
            | pending(number::SYSTICK, 26)
            | u32::from(any) << 22
            | u32::from(self.nvic.first_pending()) << 12
            | u32::from(alone) << 11
            | u32::from(self.exception)
    }

    /// Writes a register of system control.
    pub(crate) fn write_control(&mut self, address: u32, value: u32) {
        let control = &mut self.control;
        match address {
            0xE000_ED04 => self.write_icsr(value),
            0xE000_ED08 => control.vtor = value & !0x7F,
            0xE000_ED0C if value >> 16 == AIRCR_KEY => {
                control.prigroup = value >> 8 & 7;
                self.nvic.set_grouping(control.prigroup);
                if value & 1 << 2 != 0 {
                    self.state = State::ResetRequested;
                }
            }
            0xE000_ED10 => {
                control.scr = value & 0x16;
                self.nvic.event_on_pend = value & SCR_SEVONPEND != 0;
            }
            0xE000_ED14 => control.ccr = value & CCR_WRITABLE,
            0xE000_ED24 => self.write_shcsr(value),
            0xE000_ED28 => control.cfsr &= !value,
            0xE000_ED2C => control.hfsr &= !value,
            0xE000_ED30 => control.dfsr &= !value,
            0xE000_ED34 => control.mmfar = value,
            0xE000_ED38 => control.bfar = value,
            0xE000_ED88 => control.cpacr = value & 0x00F0_0000,
            0xE000_EDFC => self.set_demcr(value),
            0xE000_EF34 => control.fpccr = value & 0xC000_017B,
            0xE000_EF38 => control.fpcar = value & !7,
            0xE000_EF3C => control.fpdscr = value & 0x07C0_0000,
            _ => {}
        }
    }

    fn write_icsr(&mut self, value: u32) {
        let has = |bit: u32| value >> bit & 1 != 0;
        if has(31) {
            self.nvic.pend(number::NMI);
        }
        if has(28) {
            self.nvic.pend(number::PEND_SUPERVISOR);
        } else if has(27) {
            self.nvic.unpend(number::PEND_SUPERVISOR);
        }
        if has(26) {
            self.nvic.pend(number::SYSTICK);
        } else if has(25) {
            self.nvic.unpend(number::SYSTICK);
        }
    }

    fn write_shcsr(&mut self, value: u32) {
        let has = |bit: u32| value >> bit & 1 != 0;
        for (bit, exception) in ACTIVE_BITS {
            self.nvic.set_active(exception, has(bit));
        }
        for (bit, exception) in PENDING_BITS {
            if has(bit) {
                self.nvic.pend(exception);
            } else {
                self.nvic.unpend(exception);
            }
        }
        for (bit, exception) in ENABLE_BITS {
            self.nvic.set_enabled(exception, has(bit));
        }
    }
}
