//! Timer: a CMSDK APB timer, which counts down at the processor's clock.

use core::ptr;

/// Offsets of the registers, from the CMSDK technical reference manual.
mod register {
    pub(super) const CTRL: usize = 0x0;
    pub(super) const VALUE: usize = 0x4;
    /// The counter starts again from here, and at once when this is written.
    pub(super) const RELOAD: usize = 0x8;
    pub(super) const INT_CLEAR: usize = 0xC;
}

const CTRL_ENABLE: u32 = 1 << 0;
const CTRL_INTERRUPT: u32 = 1 << 3;

/// A timer, by the address of its registers.
#[derive(Debug)]
pub(super) struct Timer(usize);

/// Clock and cycle counter.
pub(super) const TIMER0: Timer = Timer(0x4000_0000);
/// Alarm and stopwatch.
pub(super) const TIMER1: Timer = Timer(0x4000_1000);

impl Timer {
    /// Whether the timer is running.
    pub(super) fn is_running(&self) -> bool {
        self.read(register::CTRL) & CTRL_ENABLE != 0
    }

    /// Cycles since [`count`](Self::count), modulo 2³².
    pub(super) fn elapsed(&self) -> u32 {
        u32::MAX - self.read(register::VALUE)
    }

    /// Counts cycles from 0 on; stopped before.
    pub(super) fn count(&self) {
        self.write(register::RELOAD, u32::MAX);
        self.write(register::CTRL, CTRL_ENABLE);
    }

    /// Requests an interrupt after this many cycles; stopped before.
    pub(super) fn interrupt_after(&self, cycles: u32) {
        self.write(register::RELOAD, cycles);
        self.write(register::CTRL, CTRL_ENABLE | CTRL_INTERRUPT);
    }

    /// Stops the timer, and clears its interrupt.
    pub(super) fn stop(&self) {
        self.write(register::CTRL, 0);
        self.write(register::INT_CLEAR, 1);
    }

    fn read(&self, offset: usize) -> u32 {
        // SAFETY: the address is that of a timer of this machine, as both constants are, and
        // `offset` that of one of its registers, 32 bits wide. Reading has no effect on
        // memory.
        unsafe { ptr::read_volatile((self.0 + offset) as *const u32) }
    }

    fn write(&self, offset: usize, value: u32) {
        // SAFETY: as for reading; a timer never touches memory.
        unsafe { ptr::write_volatile((self.0 + offset) as *mut u32, value) }
    }
}
