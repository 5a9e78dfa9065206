//! Semihosting: what the program asks of QEMU itself.
//!
//! Every call stops the core until the host has done it, so these are for boot,
//! rare log lines and the end.

use cortex_m_semihosting::{nr, syscall};

/// Exit code of QEMU after a panic.
pub const EXIT_PANIC: u32 = 101;
/// Exit code of QEMU after a hard fault, stack overflow included.
pub const EXIT_FAULT: u32 = 102;

/// `SYS_EXIT_EXTENDED`: unlike `SYS_EXIT` it carries an exit code.
const EXIT_EXTENDED: usize = 0x20;
/// `ADP_Stopped_ApplicationExit`.
const APPLICATION_EXIT: usize = 0x20026;

/// Whether QEMU was given `arg=WORD` on its command line, after the first one.
pub fn has_argument(word: &str) -> bool {
    let mut buffer = [0u8; 128];
    let mut block = [buffer.as_mut_ptr() as usize, buffer.len()];
    // SAFETY: SYS_GET_CMDLINE takes a buffer's address and length, both those
    // of `buffer`, and writes there a string of at most that length.
    let failed = unsafe { syscall(nr::GET_CMDLINE, &mut block) } != 0;
    let line = buffer.split(|byte| *byte == 0).next().unwrap_or_default();
    !failed && line.split(|byte| *byte == b' ').skip(1).any(|arg| arg == word.as_bytes())
}

/// Leaves QEMU with this exit code.
pub fn exit(code: u32) -> ! {
    // SAFETY: SYS_EXIT_EXTENDED takes a reason and a code, and only reads them.
    unsafe { syscall(EXIT_EXTENDED, &[APPLICATION_EXIT, code as usize]) };
    // Not reached under QEMU.
    loop {
        cortex_m::asm::wfi();
    }
}
