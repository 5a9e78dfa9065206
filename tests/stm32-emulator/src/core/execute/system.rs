//! System instructions: calls, breakpoints, waiting, special registers; and the rest of the
//! floating-point unit's. Source: DDI 0403, B5.2, A7.7 (BKPT, SVC, WFE, WFI, SEV).

use super::super::fault::{Fault, hfsr};
use super::super::instruction::Instruction;
use super::super::nvic::number;
use super::super::{Core, State};
use super::{Outcome, Stop};
use crate::memory::Memory;

const DFSR_BKPT: u32 = 1 << 1;

impl Core {
    pub(super) fn execute_system<M: Memory>(
        &mut self,
        memory: &mut M,
        instruction: Instruction,
    ) -> Outcome {
        match instruction {
            Instruction::NoOperation | Instruction::Barrier => {}
            Instruction::ClearExclusive => self.exclusive = false,
            Instruction::SendEvent => self.nvic.event = true,
            Instruction::WaitForEvent if self.nvic.event => self.nvic.event = false,
            Instruction::WaitForEvent => self.state = State::WaitingForEvent,
            Instruction::WaitForInterrupt => self.state = State::WaitingForInterrupt,
            Instruction::SupervisorCall => self.raise(number::SUPERVISOR_CALL),
            Instruction::Breakpoint { number } => return self.breakpoint(number),
            Instruction::ChangeState {
                disable,
                primask,
                faultmask,
            } => self.change_state(disable, primask, faultmask),
            Instruction::ReadSpecial { d, special } => {
                let value = self.read_special(special);
                self.put(d, value);
            }
            Instruction::WriteSpecial { n, special, mask } => {
                self.write_special(special, mask, self.get(n));
            }
            Instruction::NoCoprocessor => return Err(Fault::NoCoprocessor.into()),
            Instruction::Undefined => return Err(Fault::Undefined.into()),
            Instruction::Unimplemented | Instruction::Unknown => {
                return Err(Fault::Unimplemented.into());
            }
            other => return self.execute_float(memory, other),
        }
        Ok(0)
    }

    /// Halts for a debugger; without one it is the monitor's exception, or a hard fault.
    fn breakpoint(&mut self, number: u8) -> Outcome {
        if self.build.debugger {
            return Err(Stop::Breakpoint(number));
        }
        self.control.dfsr |= DFSR_BKPT;
        // The return address is that of the instruction.
        self.next = self.pc;
        if self.nvic.can_preempt(number::DEBUG_MONITOR) {
            self.nvic.pend(number::DEBUG_MONITOR);
        } else if self.nvic.execution_priority() < 0 {
            self.lock_up();
        } else {
            self.control.hfsr |= hfsr::DEBUGEVT;
            self.nvic.pend(number::HARD_FAULT);
        }
        Ok(0)
    }
}
