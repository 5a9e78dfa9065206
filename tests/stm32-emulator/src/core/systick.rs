//! `SysTick`: a 24-bit counter that counts down with the cycles it is given.
//!
//! Source: DDI 0403, B3.3. The other clock is an eighth of the processor's, as an STM32's is.

const ENABLE: u32 = 1 << 0;
const INTERRUPT: u32 = 1 << 1;
const PROCESSOR_CLOCK: u32 = 1 << 2;
const COUNTED: u32 = 1 << 16;

/// The timer's registers.
#[derive(Clone, Debug, Default)]
pub(crate) struct SysTick {
    control: u32,
    reload: u32,
    value: u32,
    counted: bool,
    /// Cycles towards the next count of the slow clock.
    rest: u32,
}

impl SysTick {
    #[inline]
    pub(crate) fn is_counting(&self) -> bool {
        self.control & ENABLE != 0
    }

    /// Counts; whether it requests its exception.
    pub(crate) fn advance(&mut self, cycles: u32) -> bool {
        let mut counts = cycles;
        if self.control & PROCESSOR_CLOCK == 0 {
            self.rest += cycles;
            counts = self.rest / 8;
            self.rest %= 8;
        }
        let mut reached = false;
        while counts > 0 {
            if self.value == 0 {
                // Takes the reload value in one count; 0 stays.
                if self.reload == 0 {
                    break;
                }
                self.value = self.reload;
                counts -= 1;
                continue;
            }
            let part = counts.min(self.value);
            self.value -= part;
            counts -= part;
            reached |= self.value == 0;
        }
        self.counted |= reached;
        reached && self.control & INTERRUPT != 0
    }

    /// Cycles until the next request, at least; `None` without any.
    pub(crate) fn due_in(&self) -> Option<u32> {
        if self.control & (ENABLE | INTERRUPT) != ENABLE | INTERRUPT {
            return None;
        }
        let counts = match self.value {
            0 if self.reload == 0 => return None,
            0 => self.reload + 1,
            value => value,
        };
        let slow = self.control & PROCESSOR_CLOCK == 0;
        Some(if slow { counts * 8 - self.rest } else { counts })
    }

    /// Reads a register by its offset from `0xE000_E010`.
    pub(crate) fn read(&mut self, offset: u32) -> u32 {
        match offset {
            0x0 => {
                let counted = std::mem::take(&mut self.counted);
                self.control | if counted { COUNTED } else { 0 }
            }
            0x4 => self.reload,
            0x8 => self.value,
            // No reference clock of exactly 10 ms.
            _ => 1 << 30,
        }
    }

    /// Writes a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32) {
        match offset {
            0x0 => self.control = value & (ENABLE | INTERRUPT | PROCESSOR_CLOCK),
            0x4 => self.reload = value & 0xFF_FFFF,
            0x8 => {
                self.value = 0;
                self.counted = false;
            }
            _ => {}
        }
    }
}
