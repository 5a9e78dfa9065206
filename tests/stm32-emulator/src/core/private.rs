//! The private peripherals by address: system control, NVIC, `SysTick`, MPU, FPU, DWT, ITM.
//!
//! Reserved registers read as zero and ignore writes, and so do those of units that only a
//! debugger uses: ITM ports are disabled, and so never ready for data (C1.7.3).
//! Source: DDI 0403, B3.1 and B3.4 (NVIC), C1.

use super::Core;
use super::nvic::{Nvic, number};
use super::system_control::ccr;
use crate::memory::{BusError, Width};

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
                self.bank(bank, Nvic::is_enabled)
            }
            0xE000_E200..=0xE000_E21C | 0xE000_E280..=0xE000_E29C => {
                self.bank(bank, Nvic::is_pending)
            }
            0xE000_E300..=0xE000_E31C => self.bank(bank, Nvic::is_active),
            0xE000_E400..=0xE000_E4EC => {
                self.priorities(number::INTERRUPT_0 + (address & 0xFF) as u16)
            }
            0xE000_ED18..=0xE000_ED20 => self.priorities((address - 0xE000_ED14) as u16),
            0xE000_ED40..=0xE000_ED70 => IDENTIFICATION[(address as usize - 0xE000_ED40) / 4],
            0xE000_ED90..=0xE000_EDB8 => self.mpu.read(address - 0xE000_ED90),
            _ => self.read_control(address),
        }
    }

    /// 32 interrupts, a bit each.
    fn bank(&self, bank: u16, is: fn(&Nvic, u16) -> bool) -> u32 {
        let first = number::INTERRUPT_0 + bank * 32;
        (0..32)
            .filter(|place| first + place <= self.nvic.last() && is(&self.nvic, first + place))
            .fold(0, |value, place| value | 1 << place)
    }

    fn for_bank(&mut self, bank: u16, value: u32, set: fn(&mut Nvic, u16)) {
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
            0xE000_E200..=0xE000_E21C => self.for_bank(bank, value, Nvic::pend),
            0xE000_E280..=0xE000_E29C => self.for_bank(bank, value, Nvic::unpend),
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
}
