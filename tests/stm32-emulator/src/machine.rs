//! The processor on its system, in time: from reset until the caller wants no more.

use crate::chip::Board;
use crate::core::{Build, Core, Start, Step};
use crate::image::Image;
use crate::line::Line;
use crate::peripherals::flash;
use crate::peripherals::rcc::Reset;
use crate::system::System;
use crate::time::Time;
use crate::usb_host::UsbHost;

/// A reset during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResetEvent {
    /// Its time.
    pub at: Time,
    /// Its cause.
    pub cause: Reset,
}

/// Why a machine cannot go on: the emulator's fault or the image's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// The emulator lacks an instruction.
    Unimplemented {
        /// Its address.
        pc: u32,
        /// Its encoding.
        opcode: u32,
    },
    /// A breakpoint in the program.
    Breakpoint {
        /// Its address.
        pc: u32,
    },
    /// The vector table cannot be read.
    NoVectors,
    /// The processor is locked up, and no watchdog runs.
    Lockup {
        /// Address of the instruction.
        pc: u32,
    },
}

/// A board that executes an image.
#[derive(Clone, Debug)]
pub struct Machine<L> {
    /// The processor.
    pub core: Core,
    /// All else.
    pub system: System<L>,
    resets: Vec<ResetEvent>,
}

impl<L: Line> Machine<L> {
    /// A board with this image in its flash, not yet started.
    pub fn new(board: Board, image: &Image, line: L, usb: UsbHost) -> Self {
        let mut system = System::new(board, line, usb);
        for (address, bytes) in &image.segments {
            let begin = address.wrapping_sub(flash::BASE) as usize;
            system.flash.bytes_mut()[begin..begin + bytes.len()].copy_from_slice(bytes);
        }
        let flash = flash::BASE..flash::BASE + board.chip.flash as u32;
        let core = Core::new(Build {
            interrupts: board.chip.interrupts,
            priority_bits: 4,
            vectors: flash.start,
            code: flash,
            debugger: false,
            bit_band: false,
        });
        Self {
            core,
            system,
            resets: Vec::new(),
        }
    }

    /// Resets the board for this reason.
    ///
    /// # Errors
    /// [`Halt::NoVectors`].
    pub fn reset(&mut self, cause: Reset) -> Result<(), Halt> {
        let at = self.system.now();
        self.resets.push(ResetEvent { at, cause });
        self.system.reset(cause);
        let result = self.core.reset(&mut self.system);
        result.map_err(|_| Halt::NoVectors)
    }

    /// Starts in another state than a reset leaves.
    pub fn start_at(&mut self, start: Start) {
        self.core.start_at(start);
    }

    /// Lets time pass without executing anything, as if another program ran meanwhile.
    pub fn pass_time(&mut self, until: Time) {
        self.system.jump(until);
        self.system.touch();
    }

    /// Resets so far.
    pub fn resets(&self) -> &[ResetEvent] {
        &self.resets
    }

    /// The present time.
    pub fn now(&self) -> Time {
        self.system.now()
    }

    /// Executes until `until`, or until an instruction later.
    ///
    /// # Errors
    /// If the machine cannot go on.
    pub fn run(&mut self, until: Time) -> Result<(), Halt> {
        while self.system.now() < until {
            self.step(until)?;
        }
        Ok(())
    }

    /// Executes an instruction, or sleeps until the next event, but not beyond `until`.
    ///
    /// # Errors
    /// If the machine cannot go on.
    #[inline]
    pub fn step(&mut self, until: Time) -> Result<(), Halt> {
        if self.system.is_due() {
            if self.system.now() >= self.system.iwdg.next() {
                return self.reset(Reset::Watchdog);
            }
            self.system.serve(&mut self.core);
        }
        match self.core.step(&mut self.system) {
            Step::Executed { cycles } | Step::Entered { cycles, .. } => {
                let cycles = self.system.pass(cycles);
                self.core.advance(cycles);
                Ok(())
            }
            Step::Lockup { pc } if !self.system.iwdg.is_running() => Err(Halt::Lockup { pc }),
            Step::Sleeping | Step::Lockup { .. } => {
                self.sleep(until);
                Ok(())
            }
            Step::ResetRequested => self.reset(Reset::Software),
            Step::Breakpoint(_) => Err(Halt::Breakpoint {
                pc: self.core.register(15),
            }),
            Step::Unimplemented { pc, opcode } => Err(Halt::Unimplemented { pc, opcode }),
        }
    }

    fn sleep(&mut self, until: Time) {
        let cycles = self.system.jump(self.system.next().min(until));
        self.core.advance(cycles);
    }
}
