//! Entry into exceptions: frames on the stack, vectors, and faults that occur on the way.
//!
//! The floating-point part of a frame is reserved at entry and written when a handler first
//! uses the unit (lazy stacking). Source: DDI 0403, B1.5.6 to B1.5.8 and B1.5.15.

use super::fault::{Fault, cfsr, hfsr};
use super::nvic::number;
use super::registers::control;
use super::system_control::{ccr, fpccr};
use super::{Core, State, Step, cycles};
use crate::memory::{Memory, Width};

/// Words of a frame with the state of the floating-point unit.
const EXTENDED_WORDS: u32 = 26;
const BASIC_WORDS: u32 = 8;
/// Bit of the stacked status: the stack pointer was moved to a multiple of 8.
pub(crate) const PADDED: u32 = 1 << 9;

/// Bits of `EXC_RETURN`.
pub(crate) mod exc_return {
    pub(crate) const BASE: u32 = 0xFFFF_FFE1;
    pub(crate) const PROCESS_STACK: u32 = 1 << 2;
    pub(crate) const THREAD: u32 = 1 << 3;
    pub(crate) const BASIC_FRAME: u32 = 1 << 4;
}

impl Core {
    /// Enters the exception that is ready.
    pub(crate) fn enter<M: Memory>(&mut self, memory: &mut M) -> Step {
        let exception = self.nvic.ready();
        let extended = self.special & control::FLOAT_ACTIVE != 0;
        let mut link = exc_return::BASE;
        if self.exception == 0 {
            link |= exc_return::THREAD;
        }
        if self.on_process_stack {
            link |= exc_return::PROCESS_STACK;
        }
        if !extended {
            link |= exc_return::BASIC_FRAME;
        }
        if let Err(fault) = self.push_frame(memory, extended) {
            self.fault_on_stack(fault, exception, false);
        }
        self.take(memory, link, cycles::ENTRY)
    }

    /// Enters the exception that is ready, after the frame: its vector and its state.
    pub(crate) fn take<M: Memory>(&mut self, memory: &mut M, link: u32, cycles: u32) -> Step {
        let mut exception = self.nvic.ready();
        let mut vector = self.vector(memory, exception);
        if vector.is_none() && exception > number::HARD_FAULT {
            self.control.hfsr |= hfsr::VECTTBL;
            self.nvic.pend(number::HARD_FAULT);
            exception = self.nvic.ready();
            vector = self.vector(memory, exception);
        }
        let Some(vector) = vector else {
            self.control.hfsr |= hfsr::VECTTBL;
            self.lock_up();
            return Step::Lockup { pc: self.pc };
        };
        self.count_instructions();
        self.exception = exception;
        self.r[14] = link;
        self.it = 0;
        self.special &= !(control::FLOAT_ACTIVE | control::PROCESS_STACK);
        self.select_stack(false);
        self.rights_changed();
        self.exclusive = false;
        self.previous_access = false;
        self.nvic.activate(exception);
        self.pc = vector & !1;
        self.set_thumb(vector & 1 != 0);
        Step::Entered { exception, cycles }
    }

    fn vector<M: Memory>(&mut self, memory: &mut M, exception: u16) -> Option<u32> {
        let address = self.control.vtor.wrapping_add(u32::from(exception) * 4);
        memory.read(address, Width::Word).ok()
    }

    /// Writes the frame; the stack pointer moves even if that fails.
    fn push_frame<M: Memory>(&mut self, memory: &mut M, extended: bool) -> Result<(), Fault> {
        let words = if extended {
            EXTENDED_WORDS
        } else {
            BASIC_WORDS
        };
        let aligns = extended || self.control.ccr & ccr::STKALIGN != 0;
        let old = self.r[13];
        let padded = aligns && old & 4 != 0;
        let mut frame = old.wrapping_sub(words * 4);
        if aligns {
            frame &= !4;
        }
        self.r[13] = frame;
        let status = self.status() & !PADDED | if padded { PADDED } else { 0 };
        let basic = [
            self.r[0], self.r[1], self.r[2], self.r[3], self.r[12], self.r[14], self.pc, status,
        ];
        let privileged = self.is_privileged();
        let mut result = Ok(());
        for (index, value) in (0..).zip(basic) {
            let address = frame.wrapping_add(index * 4);
            let pushed = self.store_unbuffered(memory, address, Width::Word, value, privileged);
            result = result.and(pushed);
        }
        if extended {
            self.prepare_float_frame(frame.wrapping_add(BASIC_WORDS * 4), privileged);
            if self.control.fpccr & fpccr::LSPEN == 0 {
                result = result.and(self.push_float(memory, privileged));
            }
        }
        result
    }

    /// Remembers where the unit's state belongs, and which faults may be taken for it.
    fn prepare_float_frame(&mut self, address: u32, privileged: bool) {
        let enabled = self.control.fpccr & (fpccr::ASPEN | fpccr::LSPEN);
        let bits = [
            (fpccr::LSPACT, enabled & fpccr::LSPEN != 0),
            (fpccr::USER, !privileged),
            (fpccr::THREAD, self.exception == 0),
            (fpccr::HFRDY, self.nvic.can_preempt(number::HARD_FAULT)),
            (fpccr::BFRDY, self.nvic.can_preempt(number::BUS_FAULT)),
            (fpccr::MMRDY, self.nvic.can_preempt(number::MEMORY_FAULT)),
            (fpccr::MONRDY, self.nvic.can_preempt(number::DEBUG_MONITOR)),
        ];
        let set = bits.into_iter().filter(|(_, is)| *is);
        let value = set.fold(enabled, |value, (bit, _)| value | bit);
        self.control.fpccr = value;
        self.control.fpcar = address;
    }

    /// Writes the unit's state to its place in the frame.
    fn push_float<M: Memory>(&mut self, memory: &mut M, privileged: bool) -> Result<(), Fault> {
        let address = self.control.fpcar;
        for index in 0..16_u32 {
            let value = self.s[index as usize];
            let address = address.wrapping_add(index * 4);
            self.store_unbuffered(memory, address, Width::Word, value, privileged)?;
        }
        let address = address.wrapping_add(64);
        self.store_unbuffered(memory, address, Width::Word, self.fpscr, privileged)
    }

    /// Writes the unit's state of the interrupted code, before it is used again.
    pub(crate) fn preserve_float<M: Memory>(&mut self, memory: &mut M) {
        let privileged = self.control.fpccr & fpccr::USER == 0;
        if let Err(fault) = self.push_float(memory, privileged) {
            let (bits, exception, ready) = if fault.is_access() {
                (cfsr::MLSPERR, number::MEMORY_FAULT, fpccr::MMRDY)
            } else {
                (cfsr::LSPERR, number::BUS_FAULT, fpccr::BFRDY)
            };
            self.control.cfsr |= bits;
            if self.control.fpccr & ready != 0 {
                self.nvic.pend(exception);
            } else if self.control.fpccr & fpccr::HFRDY != 0 {
                self.control.hfsr |= hfsr::FORCED;
                self.nvic.pend(number::HARD_FAULT);
            } else {
                self.lock_up();
            }
        }
        self.control.fpccr &= !fpccr::LSPACT;
    }

    /// A frame could not be written (or read, at a return): a fault on the way to `exception`.
    /// The one of higher priority is entered, and the other stays pending. On the way to
    /// `HardFault` and NMI nothing is added: the handler runs, without a frame.
    pub(crate) fn fault_on_stack(&mut self, fault: Fault, exception: u16, reading: bool) {
        let (bits, derived) = match (fault.is_access(), reading) {
            (true, false) => (cfsr::MSTKERR, number::MEMORY_FAULT),
            (true, true) => (cfsr::MUNSTKERR, number::MEMORY_FAULT),
            (false, false) => (cfsr::STKERR, number::BUS_FAULT),
            (false, true) => (cfsr::UNSTKERR, number::BUS_FAULT),
        };
        self.control.cfsr |= bits;
        if self.nvic.can_preempt(derived) {
            self.nvic.pend(derived);
        } else if exception != number::HARD_FAULT && self.nvic.execution_priority() > -1 {
            self.control.hfsr |= hfsr::FORCED;
            self.nvic.pend(number::HARD_FAULT);
        } else if reading {
            self.lock_up();
        }
    }

    /// Delivers what keeps the processor from executing; `None` if it executes.
    pub(crate) fn attend<M: Memory>(&mut self, memory: &mut M) -> Option<Step> {
        match self.state {
            State::ResetRequested => {
                self.set_thumb(self.thumb);
                return Some(Step::ResetRequested);
            }
            State::LockedUp if self.nvic.ready() != number::NMI => {
                return Some(Step::Lockup { pc: self.pc });
            }
            State::WaitingForEvent if self.nvic.event || self.nvic.ready() != 0 => {
                self.nvic.event = false;
                self.set_thumb(self.thumb);
            }
            State::WaitingForInterrupt if self.nvic.wakes() => self.set_thumb(self.thumb),
            State::WaitingForEvent | State::WaitingForInterrupt => return Some(Step::Sleeping),
            State::Running | State::NotThumb | State::LockedUp => {}
        }
        if self.nvic.ready() != 0 {
            return Some(self.enter(memory));
        }
        if self.thumb {
            return None;
        }
        self.fault(Fault::InvalidState);
        Some(self.entered_or_locked(memory))
    }

    /// Enters what a fault made pending.
    pub(crate) fn entered_or_locked<M: Memory>(&mut self, memory: &mut M) -> Step {
        if self.state == State::LockedUp {
            Step::Lockup { pc: self.pc }
        } else {
            self.enter(memory)
        }
    }
}
