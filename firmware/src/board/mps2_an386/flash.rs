//! Settings memory: the machine has no flash that a program can write, so
//! a region of its RAM replaces it.
//!
//! That region is not initialised. Settings outlive a reset of the emulated
//! machine, not the end of QEMU.

use armbridge_board::store::memory::Memory;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Bytes of a page.
const PAGE: usize = 8 * 1_024;
const LEN: usize = 2 * PAGE;
/// Marks the region as written by a program. QEMU's memory begins with
/// zeros.
const WRITTEN: u32 = 0x5E77_1465;

/// The region as flash.
pub type Flash = Memory<&'static mut [u8; LEN], PAGE>;

struct Region {
    mark: AtomicU32,
    bytes: UnsafeCell<[u8; LEN]>,
}

// SAFETY: only the caller of `take` accesses `bytes`.
unsafe impl Sync for Region {}

// SAFETY: `.uninit` is placed in RAM by cortex-m-rt's linker script, and any bits
// are a `Region`.
#[unsafe(link_section = ".uninit.FLASH")]
static REGION: Region = Region {
    mark: AtomicU32::new(0),
    bytes: UnsafeCell::new([0; LEN]),
};

/// The flash, once; blank after power-up.
pub fn take() -> Option<Flash> {
    static IS_TAKEN: AtomicBool = AtomicBool::new(false);
    if IS_TAKEN.swap(true, Ordering::Relaxed) {
        return None;
    }
    // SAFETY: this is reached once, so that there is no other reference.
    let bytes = unsafe { &mut *REGION.bytes.get() };
    if REGION.mark.swap(WRITTEN, Ordering::Relaxed) != WRITTEN {
        bytes.fill(0xFF);
    }
    Some(Memory(bytes))
}

/// Turns a bit in every sixteenth byte that has been written. End the program then: the
/// store has another picture of its memory.
pub fn damage() {
    let bytes = REGION.bytes.get().cast::<u8>();
    for offset in (0..LEN).step_by(16) {
        // SAFETY: the offset is in the region. The store to which `take` has lent it does
        // nothing meanwhile, because this runs in an interrupt, and nothing afterwards.
        unsafe {
            let byte = bytes.add(offset);
            let value = byte.read_volatile();
            if value != 0xFF {
                byte.write_volatile(value ^ 1);
            }
        }
    }
}
