//! Stack guard: the memory protection unit forbids accesses below the stack.
//!
//! The stack lies at the beginning of RAM, so that one that grows too far leaves RAM and
//! overwrites nothing. That the addresses below it fault by themselves is a property of a
//! chip; QEMU ignores such accesses. The unit makes each of them a fault on every board.

use cortex_m::peripheral::MPU;

/// First address of the stack: RAM begins there (`memory.x`).
const STACK: u32 = 0x2000_0000;

/// Forbids accesses to the `1 << LOG2` bytes below the stack; nothing that the program uses
/// may be there.
pub fn enable<const LOG2: u32>(mpu: &mut MPU) {
    const { assert!(5 <= LOG2 && LOG2 <= 28, "a region of the unit") };
    // Written with its number, 0 (VALID).
    let base = (STACK - (1 << LOG2)) | (1 << 4);
    // Enabled, its length as the exponent less one, no access, no execution.
    let attributes = (1 << 28) | ((LOG2 - 1) << 1) | 1;
    // Enabled, with the default memory map elsewhere.
    let control = (1 << 2) | 1;
    // SAFETY: the caller has nothing in the region.
    unsafe {
        mpu.rbar.write(base);
        mpu.rasr.write(attributes);
        mpu.ctrl.write(control);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
