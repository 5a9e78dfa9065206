//! Access to the processor between steps: interrupts, time, counts,
//! registers.

use super::Core;
use super::nvic::number;
use crate::memory::Width;

impl Core {
    /// Makes an interrupt pending, as a pulse of its line does.
    pub fn pend(&mut self, interrupt: u16) {
        self.nvic.pend(number::INTERRUPT_0 + interrupt);
    }

    /// Makes the non-maskable interrupt pending.
    pub fn pend_nmi(&mut self) {
        self.nvic.pend(number::NMI);
    }

    /// Sets the line of an interrupt. It becomes pending when the line rises, and again when
    /// its handler returns while the line is high.
    #[inline]
    pub fn set_line(&mut self, interrupt: u16, level: bool) {
        self.nvic.set_line(number::INTERRUPT_0 + interrupt, level);
    }

    /// Sets the event register, as an event from outside does.
    pub fn send_event(&mut self) {
        self.nvic.event = true;
    }

    /// Lets time pass: cycle counter and `SysTick` count. To be called after each step.
    #[inline]
    pub fn advance(&mut self, cycles: u32) {
        self.time += u64::from(cycles);
        if self.systick.is_counting() && self.systick.advance(cycles) {
            self.nvic.pend(number::SYSTICK);
        }
    }

    /// Cycles after which `SysTick` requests its exception next; `None` if it does not. A
    /// caller may let that many pass at once while the processor sleeps.
    pub fn systick_due(&self) -> Option<u32> {
        self.systick.due_in()
    }

    /// Cycles passed by [`Self::advance`].
    pub fn cycles(&self) -> u64 {
        self.time
    }

    /// Instructions executed so far.
    #[inline]
    pub fn executed(&self) -> u64 {
        self.executed
    }

    /// Instructions executed so far while this exception was the current one; 0 is thread
    /// mode, 16 interrupt 0.
    pub fn executed_in(&self, exception: u16) -> u64 {
        let latest = if exception == self.exception {
            self.executed - self.counted
        } else {
            0
        };
        latest + self.executed_in[usize::from(exception & 255)]
    }

    /// A general register. Between steps, 15 is the address of the next instruction, and 13 the
    /// stack pointer in use.
    ///
    /// # Panics
    /// If there is no such register.
    pub fn register(&self, number: usize) -> u32 {
        if number == 15 {
            self.pc
        } else {
            self.r[number]
        }
    }

    /// Sets a general register, as a debugger does.
    ///
    /// # Panics
    /// If there is no such register.
    pub fn set_register(&mut self, number: usize, value: u32) {
        match number {
            15 => self.pc = value & !1,
            13 => self.r[13] = value & !3,
            _ => self.r[number] = value,
        }
    }

    /// Bits of a single-precision register.
    ///
    /// # Panics
    /// If there is no such register.
    pub fn float(&self, number: usize) -> u32 {
        self.s[number]
    }

    /// Sets the bits of a single-precision register, as a debugger does.
    ///
    /// # Panics
    /// If there is no such register.
    pub fn set_float(&mut self, number: usize, bits: u32) {
        self.s[number] = bits;
    }

    /// Floating-point status and control register.
    pub fn fpscr(&self) -> u32 {
        self.fpscr
    }

    /// Program status register: APSR, IPSR and EPSR.
    pub fn xpsr(&self) -> u32 {
        self.status()
    }

    /// Sets the program status register, as a debugger does.
    pub fn set_xpsr(&mut self, value: u32) {
        self.count_instructions();
        self.set_status(value);
        self.rights_changed();
    }

    /// CONTROL.
    pub fn control(&self) -> u32 {
        self.special
    }

    /// Number of the current exception; 0 in thread mode.
    #[inline]
    pub fn exception(&self) -> u16 {
        self.exception
    }

    /// Reads a register of the private peripherals, as a debugger does; by its address, a
    /// multiple of 4 such as `0xE000_ED28` for CFSR. Reading clears what reading clears.
    pub fn system_register(&mut self, address: u32) -> u32 {
        self.read_private(address, Width::Word, true).unwrap_or(0)
    }

    /// Writes a register of the private peripherals, as a debugger does.
    pub fn set_system_register(&mut self, address: u32, value: u32) {
        // It fails for unprivileged code only.
        let _ = self.write_private(address, Width::Word, value, true);
    }
}
