//! The processor: a Cortex-M4F, executed instruction by instruction.
//!
//! [`Core::step`] delivers a pending exception or executes one instruction. The core has
//! its private peripherals itself (NVIC, system control, `SysTick`, MPU, DWT); everything
//! else is reached by [`Memory`]. It knows no time but the cycles that the
//! caller adds with [`Core::advance`], so that stalls of flash and bus count too.
//!
//! The reference is the "ARMv7-M Architecture Reference Manual" (ARM DDI 0403), and for
//! cycles and identification the "Cortex-M4 Technical Reference Manual" (ARM 100166).

mod access;
mod arithmetic;
mod bus;
mod cycles;
mod debug;
mod decode;
mod decoded;
mod exception_return;
mod exception_set;
mod exceptions;
mod execute;
mod fault;
mod float;
mod instruction;
mod interface;
mod mpu;
mod nvic;
mod operation;
mod private;
mod registers;
mod system_control;
mod systick;

pub use interface::{Build, Start, Step};

use crate::memory::{BusError, Memory, Width};
use arithmetic::{Flags, advance_it};
use decoded::Decoded;
use execute::Stop;
use fault::Fault;
use nvic::Nvic;
use system_control::SystemControl;

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
#[expect(clippy::struct_excessive_bools, reason = "bits of registers")]
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
        let (Ok(sp), Ok(pc)) = (read(memory, 0), read(memory, 4)) else {
            self.control.hfsr |= fault::hfsr::VECTTBL;
            self.lock_up();
            return Err(BusError);
        };
        self.r[13] = sp & !3;
        self.pc = pc & !1;
        self.set_thumb(pc & 1 != 0);
        Ok(())
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
                    let opcode = decoded::opcode(memory, pc);
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

    /// Counts the instructions so far for the current exception, before that changes.
    fn count_instructions(&mut self) {
        self.executed_in[usize::from(self.exception & 255)] += self.executed - self.counted;
        self.counted = self.executed;
    }
}
