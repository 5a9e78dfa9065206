//! The private peripherals by address: system control, NVIC, `SysTick`, MPU, FPU, DWT, ITM.
//!
//! Reserved registers read as zero and ignore writes, and so do those of units that only a
//! debugger uses: ITM ports are disabled, and so never ready for data (C1.7.3).
//! Source: DDI 0403, B3.2 (system control), B3.4 (NVIC), C1; 100166, 4.1 for the values.

use super::nvic::number;
use super::{Core, State};
use crate::memory::{BusError, Width};

/// Cortex-M4 r0p1.
const CPUID: u32 = 0x410F_C241;
const AIRCR_KEY: u32 = 0x05FA;
const CCR_WRITABLE: u32 = 0x31B;
/// Instruction set attributes: `ID_PFR0` to `ID_ISAR4`.
const IDENTIFICATION: [u32; 13] = [
    0x30,
    0x200,
    0x10_0000,
    0,
    0x10_0030,
    0,
    0x0100_0000,
    0,
    0x0110_1110,
    0x0211_2000,
    0x2123_2231,
    0x0111_1131,
    0x0131_0132,
];
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
    /// Reads a private peripheral.
    pub(crate) fn read_private(
        &mut self,
        address: u32,
        width: Width,
        privileged: bool,
    ) -> Result<u32, BusError> {
        if !privileged {
            return Err(BusError);
        }
        let places = (address & 3) * 8;
        let value = self.read_word(address & !3) >> places;
        Ok(match width {
            Width::Byte => value & 0xFF,
            Width::Half => value & 0xFFFF,
            Width::Word => value,
        })
    }

    /// Writes a private peripheral.
    pub(crate) fn write_private(
        &mut self,
        address: u32,
        width: Width,
        value: u32,
        privileged: bool,
    ) -> Result<(), BusError> {
        let by_user = address & !3 == 0xE000_EF00 && self.control.ccr & ccr::USERSETMPEND != 0;
        if !privileged && !by_user {
            return Err(BusError);
        }
        let places = (address & 3) * 8;
        let mask = match width {
            Width::Byte => 0xFF << places,
            Width::Half => 0xFFFF << places,
            Width::Word => u32::MAX,
        };
        let word = address & !3;
        // Other bytes keep their values; of registers whose ones set or clear they get zeros.
        let kept = match word {
            _ if width == Width::Word => 0,
            0xE000_E100..=0xE000_E3FC | 0xE000_ED04 | 0xE000_ED0C | 0xE000_ED28..=0xE000_ED30 => 0,
            _ => self.read_word(word) & !mask,
        };
        self.write_word(word, value << places & mask | kept);
        self.checked = self.mpu.is_enabled() || self.control.ccr & ccr::UNALIGN_TRP != 0;
        self.rights_changed();
        Ok(())
    }

    fn read_word(&mut self, address: u32) -> u32 {
        let bank = (address >> 2 & 7) as u16;
        match address {
            0xE000_1000 => 4 << 28 | u32::from(self.debug.counts),
            0xE000_1004 => self.cycle_count(),
            0xE000_E004 => u32::from(self.build.interrupts.div_ceil(32).max(1)) - 1,
            0xE000_E008 => self.control.actlr,
            0xE000_E010..=0xE000_E01C => self.systick.read(address & 0xF),
            0xE000_E100..=0xE000_E11C | 0xE000_E180..=0xE000_E19C => {
                self.bank(bank, super::nvic::Nvic::is_enabled)
            }
            0xE000_E200..=0xE000_E21C | 0xE000_E280..=0xE000_E29C => {
                self.bank(bank, super::nvic::Nvic::is_pending)
            }
            0xE000_E300..=0xE000_E31C => self.bank(bank, super::nvic::Nvic::is_active),
            0xE000_E400..=0xE000_E4EC => {
                self.priorities(number::INTERRUPT_0 + (address & 0xFF) as u16)
            }
            0xE000_ED18..=0xE000_ED20 => self.priorities((address - 0xE000_ED14) as u16),
            0xE000_ED40..=0xE000_ED70 => IDENTIFICATION[(address as usize - 0xE000_ED40) / 4],
            0xE000_ED90..=0xE000_EDB8 => self.mpu.read(address - 0xE000_ED90),
            _ => self.read_control(address),
        }
    }

    fn read_control(&self, address: u32) -> u32 {
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

    /// 32 interrupts, a bit each.
    fn bank(&self, bank: u16, is: fn(&super::nvic::Nvic, u16) -> bool) -> u32 {
        let first = number::INTERRUPT_0 + bank * 32;
        (0..32)
            .filter(|place| first + place <= self.nvic.last() && is(&self.nvic, first + place))
            .fold(0, |value, place| value | 1 << place)
    }

    fn for_bank(&mut self, bank: u16, value: u32, set: fn(&mut super::nvic::Nvic, u16)) {
        let first = number::INTERRUPT_0 + bank * 32;
        for place in (0..32).filter(|place| value >> place & 1 != 0) {
            if first + place <= self.nvic.last() {
                set(&mut self.nvic, first + place);
            }
        }
    }

    /// Priorities of four exceptions.
    fn priorities(&self, first: u16) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|place| {
            self.nvic.priority_bits(first + place as u16)
        }))
    }

    fn set_priorities(&mut self, first: u16, value: u32) {
        for (exception, byte) in (first..).zip(value.to_le_bytes()) {
            self.nvic.set_priority_bits(exception, byte);
        }
    }

    fn write_word(&mut self, address: u32, value: u32) {
        let bank = (address >> 2 & 7) as u16;
        match address {
            0xE000_1000 => self.set_counting(value & 1 != 0),
            0xE000_1004 => self.set_cycle_count(value),
            0xE000_E008 => self.control.actlr = value & 0x307,
            0xE000_E010..=0xE000_E01C => self.systick.write(address & 0xF, value),
            0xE000_E100..=0xE000_E11C => self.for_bank(bank, value, |nvic, exception| {
                nvic.set_enabled(exception, true);
            }),
            0xE000_E180..=0xE000_E19C => self.for_bank(bank, value, |nvic, exception| {
                nvic.set_enabled(exception, false);
            }),
            0xE000_E200..=0xE000_E21C => self.for_bank(bank, value, super::nvic::Nvic::pend),
            0xE000_E280..=0xE000_E29C => self.for_bank(bank, value, super::nvic::Nvic::unpend),
            0xE000_E400..=0xE000_E4EC => {
                self.set_priorities(number::INTERRUPT_0 + (address & 0xFF) as u16, value);
            }
            0xE000_ED18..=0xE000_ED20 => {
                self.set_priorities((address - 0xE000_ED14) as u16, value);
            }
            0xE000_ED90..=0xE000_EDB8 => self.mpu.write(address - 0xE000_ED90, value),
            0xE000_EF00 => self.nvic.pend(number::INTERRUPT_0 + (value & 0x1FF) as u16),
            _ => self.write_control(address, value),
        }
    }

    fn write_control(&mut self, address: u32, value: u32) {
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
