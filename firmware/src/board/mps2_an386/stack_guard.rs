//! Stack guard: forbids accesses below the stack.
//!
//! No memory is mapped there, but QEMU ignores accesses to unmapped addresses on this
//! machine: a stack overflow would not be detected. The memory protection
//! unit makes it a hard fault, as it is on the real board.

use cortex_m::peripheral::MPU;

/// Region 0, from 0x10000000, to be written with its number (VALID).
const RBAR: u32 = 0x1000_0000 | 1 << 4;
/// Enabled, 2²⁸ bytes (the exponent less one), no access, no execution: up to
/// where the stack begins.
const RASR: u32 = 1 << 28 | 27 << 1 | 1;
/// Enabled, with the default memory map elsewhere.
const CTRL: u32 = 1 << 2 | 1;

/// Forbids access below the stack.
pub fn enable(mpu: &mut MPU) {
    // SAFETY: nothing this program uses lies in the region, code being below it
    // and data above.
    unsafe {
        mpu.rbar.write(RBAR);
        mpu.rasr.write(RASR);
        mpu.ctrl.write(CTRL);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
