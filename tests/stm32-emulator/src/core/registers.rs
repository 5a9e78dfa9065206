//! Registers of the core: stack pointers, status, special registers.
//!
//! Register 13 is the stack pointer in use; the other one is kept beside. Source: DDI 0403,
//! B1.4 (registers) and B5.2 (MRS, MSR, CPS).

use super::arithmetic::Flags;
use super::instruction::Reg;
use super::{Core, State};

/// Bits of CONTROL.
pub(crate) mod control {
    pub(crate) const UNPRIVILEGED: u32 = 1 << 0;
    pub(crate) const PROCESS_STACK: u32 = 1 << 1;
    pub(crate) const FLOAT_ACTIVE: u32 = 1 << 2;
}

/// The T bit of EPSR.
pub(crate) const THUMB: u32 = 1 << 24;

impl Core {
    /// Reads a register; 15 is the address of the instruction plus 4.
    #[inline]
    pub(crate) fn get(&self, register: Reg) -> u32 {
        self.r[usize::from(register & 15)]
    }

    /// Writes a register other than the program counter.
    #[inline]
    pub(crate) fn put(&mut self, register: Reg, value: u32) {
        let value = if register == 13 { value & !3 } else { value };
        self.r[usize::from(register & 15)] = value;
    }

    /// Whether code has all rights.
    pub(crate) fn is_privileged(&self) -> bool {
        self.exception != 0 || self.special & control::UNPRIVILEGED == 0
    }

    /// Selects the stack pointer that register 13 is.
    pub(crate) fn select_stack(&mut self, process: bool) {
        if self.on_process_stack != process {
            std::mem::swap(&mut self.r[13], &mut self.other_stack);
            self.on_process_stack = process;
        }
    }

    /// Changes CONTROL, and with it the stack in use.
    pub(crate) fn set_control(&mut self, value: u32) {
        self.special = value & 7;
        let process = value & control::PROCESS_STACK != 0;
        self.select_stack(process && self.exception == 0);
        self.rights_changed();
    }

    /// State that depends on privileges, exception or CONTROL is checked anew.
    pub(crate) fn rights_changed(&mut self) {
        self.float_ready = false;
        self.fetch_granule = u32::MAX;
    }

    /// Sets the T bit; without it the next instruction faults.
    pub(crate) fn set_thumb(&mut self, thumb: bool) {
        self.thumb = thumb;
        self.state = if thumb {
            State::Running
        } else {
            State::NotThumb
        };
    }

    /// APSR, IPSR and EPSR.
    pub(crate) fn status(&self) -> u32 {
        let it = u32::from(self.it);
        self.application_status()
            | u32::from(self.exception)
            | (it & 3) << 25
            | (it >> 2) << 10
            | if self.thumb { THUMB } else { 0 }
    }

    /// Sets APSR, IPSR and EPSR.
    pub(crate) fn set_status(&mut self, value: u32) {
        self.set_application_status(value, true, true);
        self.exception = (value & 0x1FF) as u16;
        self.it = (value >> 25 & 3 | value >> 8 & 0xFC) as u8;
        self.set_thumb(value & THUMB != 0);
    }

    fn application_status(&self) -> u32 {
        self.flags.bits() | u32::from(self.saturated) << 27 | u32::from(self.greater) << 16
    }

    fn set_application_status(&mut self, value: u32, flags: bool, greater: bool) {
        if flags {
            self.flags = Flags::from_bits(value);
            self.saturated = value >> 27 & 1 != 0;
        }
        if greater {
            self.greater = (value >> 16 & 15) as u8;
        }
    }

    fn stack_pointer(&self, process: bool) -> u32 {
        if process == self.on_process_stack {
            self.r[13]
        } else {
            self.other_stack
        }
    }

    fn set_stack_pointer(&mut self, process: bool, value: u32) {
        if process == self.on_process_stack {
            self.r[13] = value & !3;
        } else {
            self.other_stack = value & !3;
        }
    }

    /// MRS.
    pub(crate) fn read_special(&self, special: u8) -> u32 {
        let (primask, faultmask, basepri) = self.nvic.masks();
        let privileged = self.is_privileged();
        match special {
            0..=7 => {
                let mut value = 0;
                if special & 1 != 0 {
                    value |= u32::from(self.exception);
                }
                // EPSR reads as zero.
                if special & 4 == 0 {
                    value |= self.application_status();
                }
                value
            }
            8 if privileged => self.stack_pointer(false),
            9 if privileged => self.stack_pointer(true),
            16 if privileged => u32::from(primask),
            17 | 18 if privileged => u32::from(basepri),
            19 if privileged => u32::from(faultmask),
            20 => self.special,
            _ => 0,
        }
    }

    /// MSR.
    pub(crate) fn write_special(&mut self, special: u8, mask: u8, value: u32) {
        let low = value as u8;
        match special {
            0..=3 => self.set_application_status(value, mask & 2 != 0, mask & 1 != 0),
            _ if !self.is_privileged() => {}
            8 => self.set_stack_pointer(false, value),
            9 => self.set_stack_pointer(true, value),
            16 => self.nvic.set_primask(value & 1 != 0),
            17 => self.nvic.set_basepri(low),
            18 => {
                let (.., basepri) = self.nvic.masks();
                if low != 0 && (low < basepri || basepri == 0) {
                    self.nvic.set_basepri(low);
                }
            }
            19 => self.change_faultmask(value & 1 != 0),
            20 => {
                let kept = if self.exception == 0 {
                    0
                } else {
                    self.special & control::PROCESS_STACK
                };
                let writable = if self.exception == 0 { 7 } else { 5 };
                self.set_control(value & writable | kept);
            }
            _ => {}
        }
    }

    /// FAULTMASK cannot be set in `HardFault` and NMI.
    fn change_faultmask(&mut self, value: bool) {
        if !value || self.nvic.execution_priority() > -1 {
            self.nvic.set_faultmask(value);
            self.rights_changed();
        }
    }

    /// CPS.
    pub(crate) fn change_state(&mut self, disable: bool, primask: bool, faultmask: bool) {
        if !self.is_privileged() {
            return;
        }
        if primask {
            self.nvic.set_primask(disable);
        }
        if faultmask {
            self.change_faultmask(disable);
        }
    }
}
