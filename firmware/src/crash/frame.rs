//! Exception frame on the stack, and detection of a stack overflow.
//!
//! The processor pushes eight words before it enters a handler: r0 to r3, r12,
//! lr, pc and the status register (ARMv7-M Architecture Reference Manual,
//! B1.5.6), more below them if the floating-point unit is in use. The process
//! stack is not used, so they are at the main stack pointer.

use core::ops::Range;

/// Bytes of the eight words.
pub const FRAME_LEN: u32 = 32;
/// Offset of pc in the frame.
pub const PC_OFFSET: u32 = 24;

/// An access that fails with less than this left, in bytes, failed for lack of
/// stack: an instruction pushes at most 16 registers or 32 of the floating-point
/// unit.
const PUSH_MAX: u32 = 128;

/// Bits of the configurable fault status register (B3.2.15) that are set if
/// registers could not be pushed: MSTKERR, MLSPERR, STKERR, LSPERR.
const STACKING_FAILED: u32 = 1 << 4 | 1 << 5 | 1 << 12 | 1 << 13;

/// Whether the stack overflowed. `frame` is the address of the eight words,
/// `stack` the range of valid addresses.
pub fn is_overflow(frame: u32, fault_status: u32, stack: &Range<u32>) -> bool {
    frame < stack.start.saturating_add(PUSH_MAX) || fault_status & STACKING_FAILED != 0
}

/// Address of pc in the frame, if the frame is valid.
pub fn pc_address(frame: u32, fault_status: u32, stack: &Range<u32>) -> Option<u32> {
    let is_valid = frame.is_multiple_of(4)
        && frame >= stack.start
        && frame <= stack.end.saturating_sub(FRAME_LEN)
        && fault_status & STACKING_FAILED == 0;
    is_valid.then(|| frame + PC_OFFSET)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STACK: Range<u32> = 0x2000_0000..0x2000_8000;

    #[test]
    fn overflow_is_told_from_other_faults() {
        assert!(!is_overflow(0x2000_7F00, 0, &STACK));
        // A load from nowhere (PRECISERR) is none.
        assert!(!is_overflow(0x2000_7F00, 1 << 9, &STACK));
        // A push that did not fit leaves the pointer above the end.
        assert!(is_overflow(0x2000_0024, 1 << 9, &STACK));
        assert!(is_overflow(0x1FFF_FF00, 0, &STACK));
        assert!(is_overflow(0x2000_7F00, 1 << 4, &STACK));
    }

    #[test]
    fn pc_is_read_from_within_the_stack_alone() {
        let pc = |frame, status| pc_address(frame, status, &STACK);
        assert_eq!(pc(0x2000_7FE0, 0), Some(0x2000_7FF8));
        assert_eq!(pc(0x2000_0000, 0), Some(0x2000_0018));
        for frame in [0x2000_7FE4, 0x1FFF_FFFC, 0x2000_7F02, 0, u32::MAX] {
            assert_eq!(pc(frame, 0), None);
        }
        assert_eq!(pc(0x2000_7000, 1 << 12), None);
    }
}
