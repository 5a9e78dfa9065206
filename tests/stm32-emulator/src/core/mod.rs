//! The processor: a Cortex-M4F, executed instruction by instruction.
//!
//! [`Core::step`] delivers a pending exception or executes one instruction. The core has
//! its private peripherals itself (NVIC, system control, `SysTick`, MPU, DWT); everything
//! else is reached by [`Memory`]. It knows no time but the cycles that the
//! caller adds with [`Core::advance`], so that stalls of flash and bus count too.
//!
//! The reference is the "ARMv7-M Architecture Reference Manual" (ARM DDI 0403), and for
//! cycles and identification the "Cortex-M4 Technical Reference Manual" (ARM 100166).

mod arithmetic;
mod bus;
mod cycles;
mod debug;
mod decode;
mod decoded;
mod exception_return;
mod exceptions;
mod execute;
mod fault;
mod float;
mod instruction;
mod mpu;
mod nvic;
mod registers;
mod system_control;
mod systick;

use crate::memory::{BusError, Memory, Width};
use arithmetic::{Flags, advance_it};
use decoded::Decoded;
use execute::Stop;
use fault::Fault;
use nvic::{Nvic, number};
use system_control::SystemControl;

use std::ops::Range;

/// What a chip chose of the options that the processor leaves to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Build {
    /// Number of interrupts, at most 240.
    pub interrupts: u16,
    /// Implemented bits of a priority, 3 to 8: 4 for an STM32.
    pub priority_bits: u8,
    /// Address of the vector table at reset.
    pub vectors: u32,
    /// Addresses of which decoded instructions are kept until [`Core::invalidate`]: memory
    /// that programs do not write.
    pub code: Range<u32>,
    /// Whether a debugger halts at BKPT ([`Step::Breakpoint`]); otherwise it is a fault.
    pub debugger: bool,
    /// Whether the bit-band aliases exist.
    pub bit_band: bool,
}

/// State in which a program starts other than by a reset, as a ROM boot loader leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// Main stack pointer.
    pub sp: u32,
    /// Address of the first instruction; bit 0 is ignored.
    pub pc: u32,
    /// Vector table offset register.
    pub vtor: u32,
    /// Whether exceptions of settable priority are masked.
    pub primask: bool,
}

/// What a step did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One instruction was executed.
    Executed {
        /// Cycles it took, without stalls of the memory.
        cycles: u32,
    },
    /// An exception was entered; no instruction was executed.
    Entered {
        /// Its number: 16 is interrupt 0.
        exception: u16,
        /// Cycles it took, without stalls of the memory.
        cycles: u32,
    },
    /// The processor sleeps, and nothing wakes it yet.
    Sleeping,
    /// The program requested a reset (`AIRCR.SYSRESETREQ`); the next step goes on without one.
    ResetRequested,
    /// BKPT with this number; the program counter is behind it.
    Breakpoint(u8),
    /// The emulator lacks this instruction; it was a usage fault (UNDEFINSTR).
    Unimplemented {
        /// Address of the instruction.
        pc: u32,
        /// Its first halfword in bits 31 to 16 if it has two, its only one in bits 15 to 0.
        opcode: u32,
    },
    /// The processor is locked up at this instruction, until a reset.
    Lockup {
        /// Address of the instruction.
        pc: u32,
    },
}

impl Step {
    /// Cycles of the step, without stalls of the memory.
    pub fn cycles(self) -> u32 {
        match self {
            Self::Executed { cycles } | Self::Entered { cycles, .. } => cycles,
            _ => 1,
        }
    }
}

/// Whether the processor executes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Running,
    /// The T bit is clear: the next instruction faults.
    NotThumb,
    WaitingForEvent,
    WaitingForInterrupt,
    ResetRequested,
    LockedUp,
}

/// The processor.
#[derive(Clone, Debug)]
pub struct Core {
    build: Build,
    /// General registers; 13 is the stack pointer in use, 15 is set while an instruction is
    /// executed.
    r: [u32; 16],
    /// The stack pointer not in use.
    other_stack: u32,
    on_process_stack: bool,
    /// Address of the next instruction.
    pc: u32,
    /// While an instruction is executed, the address of the one after it.
    next: u32,
    flags: Flags,
    saturated: bool,
    greater: u8,
    it: u8,
    thumb: bool,
    exception: u16,
    /// CONTROL.
    special: u32,
    exclusive: bool,
    state: State,

    s: [u32; 32],
    fpscr: u32,
    /// Whether the unit may be used without further checks.
    float_ready: bool,
    /// The last result of arithmetic, and the count of instructions at which it is late.
    float_result: (u64, u8),

    nvic: Nvic,
    control: SystemControl,
    systick: systick::SysTick,
    mpu: mpu::Mpu,
    debug: debug::Debug,
    /// Whether accesses of memory have to be checked.
    checked: bool,
    /// The 32 bytes in which fetches are known to be allowed.
    fetch_granule: u32,

    decoded: Vec<Decoded>,
    /// Whether the last instruction was a single access.
    previous_access: bool,
    time: u64,
    executed: u64,
    /// Of which are in `executed_in`.
    counted: u64,
    executed_in: Vec<u64>,
}

impl Core {
    /// A processor that was not reset yet.
    pub fn new(build: Build) -> Self {
        let kept = build.code.len().div_ceil(2);
        Self {
            nvic: Nvic::new(build.interrupts, build.priority_bits),
            control: SystemControl::new(build.vectors),
            systick: systick::SysTick::default(),
            mpu: mpu::Mpu::default(),
            debug: debug::Debug::default(),
            r: [0; 16],
            other_stack: 0,
            on_process_stack: false,
            pc: 0,
            next: 0,
            flags: Flags::default(),
            saturated: false,
            greater: 0,
            it: 0,
            thumb: true,
            exception: 0,
            special: 0,
            exclusive: false,
            state: State::Running,
            s: [0; 32],
            fpscr: 0,
            float_ready: false,
            float_result: (0, 0),
            checked: false,
            fetch_granule: u32::MAX,
            decoded: vec![Decoded::UNKNOWN; kept + 1],
            previous_access: false,
            time: 0,
            executed: 0,
            counted: 0,
            executed_in: vec![0; 256],
            build,
        }
    }

    /// Resets the processor: stack pointer and program counter come from the vector table.
    /// General registers, those of the floating-point unit, the cycle counter and DEMCR keep
    /// their values, as on silicon; so do the lines of interrupts, and the emulator's counts.
    ///
    /// # Errors
    /// [`BusError`] if the vector table cannot be read: the processor is locked up.
    pub fn reset(&mut self, memory: &mut impl Memory) -> Result<(), BusError> {
        let vtor = self.build.vectors;
        self.start(vtor);
        let read = |memory: &mut dyn Memory, offset| memory.read(vtor + offset, Width::Word);
        match (read(memory, 0), read(memory, 4)) {
            (Ok(sp), Ok(pc)) => {
                self.r[13] = sp & !3;
                self.pc = pc & !1;
                self.set_thumb(pc & 1 != 0);
                Ok(())
            }
            _ => {
                self.control.hfsr |= fault::hfsr::VECTTBL;
                self.lock_up();
                Err(BusError)
            }
        }
    }

    /// Resets the processor, but starts it in another state than a reset does.
    pub fn start_at(&mut self, start: Start) {
        self.start(start.vtor);
        self.r[13] = start.sp & !3;
        self.pc = start.pc & !1;
        self.nvic.set_primask(start.primask);
    }

    fn start(&mut self, vtor: u32) {
        self.count_instructions();
        self.nvic.reset();
        self.control = SystemControl::new(vtor);
        self.systick = systick::SysTick::default();
        self.mpu = mpu::Mpu::default();
        self.set_demcr(self.debug.demcr);
        self.flags = Flags::default();
        self.saturated = false;
        self.greater = 0;
        self.it = 0;
        self.exception = 0;
        self.special = 0;
        self.exclusive = false;
        self.select_stack(false);
        self.r[14] = u32::MAX;
        self.fpscr = 0;
        self.checked = false;
        self.previous_access = false;
        self.rights_changed();
        self.set_thumb(true);
    }

    /// Delivers a pending exception or executes one instruction.
    #[inline]
    pub fn step<M: Memory>(&mut self, memory: &mut M) -> Step {
        if (self.nvic.ready() != 0 || self.state != State::Running)
            && let Some(step) = self.attend(memory)
        {
            return step;
        }
        let address = self.pc;
        let place = match self.fetch(memory, address) {
            Ok(place) => place,
            Err(fault) => return self.stopped(memory, Stop::Fault(fault)),
        };
        let halfwords = u32::from(self.decoded[place].halfwords);
        memory.executes(address, halfwords);
        self.r[15] = address.wrapping_add(4);
        self.next = address.wrapping_add(halfwords * 2);
        let it = self.it;
        if it != 0 {
            if !self.flags.hold(it >> 4) && !self.decoded[place].is_unconditional() {
                self.it = advance_it(it);
                return self.executed_in_cycles(1, false);
            }
            return match self.execute(memory, place) {
                Ok(more) => {
                    self.it = advance_it(it);
                    self.finish(place, more)
                }
                Err(stop) => self.stopped(memory, stop),
            };
        }
        match self.execute(memory, place) {
            Ok(more) => self.finish(place, more),
            Err(stop) => self.stopped(memory, stop),
        }
    }

    /// An instruction is done.
    #[inline]
    fn finish(&mut self, place: usize, more: u32) -> Step {
        let decoded = &self.decoded[place];
        let saved = u32::from(decoded.is_paired && self.previous_access);
        let cycles = u32::from(decoded.cycles) + more - saved;
        let access = decoded.is_access;
        self.executed_in_cycles(cycles, access)
    }

    #[inline]
    fn executed_in_cycles(&mut self, cycles: u32, access: bool) -> Step {
        self.pc = self.next;
        self.executed += 1;
        self.previous_access = access;
        Step::Executed { cycles }
    }

    /// An instruction did not simply go on to the next.
    #[inline(never)]
    fn stopped<M: Memory>(&mut self, memory: &mut M, stop: Stop) -> Step {
        match stop {
            Stop::Fault(fault) => {
                let pc = self.pc;
                self.fault(fault);
                if fault == Fault::Unimplemented {
                    let opcode = self.opcode(memory, pc);
                    return Step::Unimplemented { pc, opcode };
                }
                self.entered_or_locked(memory)
            }
            Stop::Return(value) => {
                self.executed += 1;
                self.return_from_exception(memory, value)
            }
            Stop::Breakpoint(number) => {
                self.executed_in_cycles(1, false);
                Step::Breakpoint(number)
            }
        }
    }

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

    /// Counts the instructions so far for the current exception, before that changes.
    fn count_instructions(&mut self) {
        self.executed_in[usize::from(self.exception & 255)] += self.executed - self.counted;
        self.counted = self.executed;
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
}
