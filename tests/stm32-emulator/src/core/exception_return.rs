//! Return from exceptions: checks, tail-chaining, frames off the stack.
//!
//! Source: DDI 0403, B1.5.8 (return), B1.5.12 (tail-chaining), B1.5.18 (SLEEPONEXIT).

use super::exceptions::{PADDED, exc_return};
use super::fault::{Fault, cfsr};
use super::nvic::number;
use super::registers::control;
use super::system_control::{SCR_SLEEPONEXIT, ccr, fpccr};
use super::{Core, State, Step, cycles};
use crate::memory::{Memory, Width};

impl Core {
    /// A handler's last instruction put this value into the program counter.
    pub(crate) fn return_from_exception<M: Memory>(&mut self, memory: &mut M, value: u32) -> Step {
        let returning = self.exception;
        let valid = self.is_valid_return(value, returning);
        self.nvic.deactivate(returning);
        if !valid {
            return self.fault_at_return(memory, value);
        }
        if self.nvic.ready() != 0 {
            // The frame stays for the next return.
            return self.take(memory, value, cycles::TAIL_CHAIN);
        }
        let thread = value & exc_return::THREAD != 0;
        let process = value & exc_return::PROCESS_STACK != 0;
        let extended = value & exc_return::BASIC_FRAME == 0;
        self.count_instructions();
        // The handler's rights end, and its stack, before the frame is read.
        let old = (self.exception, self.special);
        self.special &= !(control::PROCESS_STACK | control::FLOAT_ACTIVE);
        if process {
            self.special |= control::PROCESS_STACK;
        }
        if thread {
            self.exception = 0;
        }
        self.select_stack(process);
        let popped = self.pop_frame(memory, extended);
        self.rights_changed();
        let status = match popped {
            Ok(status) => status,
            Err(fault) => {
                (self.exception, self.special) = old;
                self.fault_on_stack(fault, 0, true);
                if self.state == State::LockedUp {
                    return Step::Lockup { pc: self.pc };
                }
                return self.take(memory, value, cycles::TAIL_CHAIN);
            }
        };
        if extended {
            self.special |= control::FLOAT_ACTIVE;
        }
        self.set_status(status);
        self.exclusive = false;
        self.previous_access = false;
        self.nvic.event = true;
        if (self.exception == 0) != thread {
            // The frame belongs to another mode.
            self.fault(Fault::InvalidPc);
            return self.entered_or_locked(memory);
        }
        if thread && self.control.scr & SCR_SLEEPONEXIT != 0 {
            self.state = State::WaitingForInterrupt;
        }
        Step::Executed {
            cycles: cycles::RETURN,
        }
    }

    fn is_valid_return(&self, value: u32, returning: u16) -> bool {
        let alone = self.nvic.active_count() == 1;
        let is_active = self.nvic.is_active(returning);
        let to_thread = alone || self.control.ccr & ccr::NONBASETHRDENA != 0;
        let mode = match value & 15 {
            0x1 => !alone,
            0x9 | 0xD => to_thread,
            _ => false,
        };
        is_active && mode && value >> 5 == u32::MAX >> 5
    }

    /// An invalid return: a usage fault instead, on the same frame.
    fn fault_at_return<M: Memory>(&mut self, memory: &mut M, value: u32) -> Step {
        self.control.cfsr |= cfsr::INVPC;
        self.raise(number::USAGE_FAULT);
        if self.state == State::LockedUp {
            return Step::Lockup { pc: self.pc };
        }
        self.take(memory, value | 0xF000_0000, cycles::TAIL_CHAIN)
    }

    /// Reads the frame into the registers; its status, which is not set yet.
    fn pop_frame<M: Memory>(&mut self, memory: &mut M, extended: bool) -> Result<u32, Fault> {
        let privileged = self.is_privileged();
        let frame = self.r[13];
        let mut words = [0; 8];
        for (index, word) in (0..).zip(&mut words) {
            let address = frame.wrapping_add(index * 4);
            *word = self.load_checked(memory, address, Width::Word, privileged)?;
        }
        let mut size = 32;
        if extended {
            size = 104;
            if self.control.fpccr & fpccr::LSPACT != 0 {
                // The unit was not used: its registers are still those of the frame.
                self.control.fpccr &= !fpccr::LSPACT;
            } else {
                self.pop_float(memory, frame.wrapping_add(32), privileged)?;
            }
        }
        let [r0, r1, r2, r3, r12, link, pc, status] = words;
        self.r[..4].copy_from_slice(&[r0, r1, r2, r3]);
        self.r[12] = r12;
        self.r[14] = link;
        self.pc = pc & !1;
        let aligns = extended || self.control.ccr & ccr::STKALIGN != 0;
        let padding = u32::from(aligns && status & PADDED != 0) * 4;
        self.r[13] = frame.wrapping_add(size) | padding;
        Ok(status)
    }

    fn pop_float<M: Memory>(
        &mut self,
        memory: &mut M,
        address: u32,
        privileged: bool,
    ) -> Result<(), Fault> {
        for index in 0..16_u32 {
            let address = address.wrapping_add(index * 4);
            self.s[index as usize] = self.load_checked(memory, address, Width::Word, privileged)?;
        }
        self.fpscr =
            self.load_checked(memory, address.wrapping_add(64), Width::Word, privileged)?;
        Ok(())
    }
}
