//! Semihosting: requests of the program to QEMU.
//!
//! Every call stops the core until the host has done it, so they are used at boot,
//! for rare log lines, at the end, and in lockstep, where the stop is intended.

use cortex_m_semihosting::{nr, syscall};

/// Exit code of QEMU after a panic.
pub const EXIT_PANIC: u32 = 101;
/// Exit code of QEMU after a hard fault, stack overflow included.
pub const EXIT_FAULT: u32 = 102;
/// Exit code of QEMU when the bench has gone.
pub const EXIT_NO_BENCH: u32 = 103;

/// `SYS_EXIT_EXTENDED`: unlike `SYS_EXIT` it carries an exit code.
const EXIT_EXTENDED: usize = 0x20;
/// `ADP_Stopped_ApplicationExit`.
const APPLICATION_EXIT: usize = 0x20026;

/// Words of `arg=WORD` on the command line of QEMU, after the first one.
#[derive(Debug)]
pub struct Arguments {
    line: [u8; 128],
}

impl Arguments {
    /// Reads the words from QEMU; empty if there are none.
    pub fn get() -> Self {
        let mut line = [0; 128];
        let block = [line.as_mut_ptr() as usize, line.len()];
        // SAFETY: SYS_GET_CMDLINE takes a buffer's address and length, both
        // those of `line`, and writes there a string of at most that length.
        if unsafe { syscall(nr::GET_CMDLINE, &block) } != 0 {
            line = [0; 128];
        }
        Self { line }
    }

    fn words(&self) -> impl Iterator<Item = &[u8]> {
        let line = self.line.split(|byte| *byte == 0).next();
        line.unwrap_or_default().split(|byte| *byte == b' ').skip(1)
    }

    /// Whether `word` is an argument.
    pub fn has(&self, word: &str) -> bool {
        self.words().any(|argument| argument == word.as_bytes())
    }

    /// The number after `name` in an argument such as `slow=20`, if there is one.
    pub fn number(&self, name: &str) -> Option<u32> {
        let digits = self
            .words()
            .find_map(|word| word.strip_prefix(name.as_bytes()))?;
        str::from_utf8(digits).ok()?.parse().ok()
    }
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

/// Sends a defmt frame to the semihosting console.
pub fn print(frame: &[u8]) {
    // A zero only ends a frame (rzCOBS), and SYS_WRITE0 sends up to a zero: two
    // calls, however long the frame is.
    for part in frame.split_inclusive(|byte| *byte == 0) {
        if part.ends_with(&[0]) {
            // SAFETY: SYS_WRITE0 reads from this address up to a zero, which is
            // the last byte of `part`.
            unsafe { cortex_m_semihosting::syscall1(nr::WRITE0, part.as_ptr() as usize) };
            // SAFETY: SYS_WRITEC reads one byte.
            unsafe { syscall(nr::WRITEC, &0u8) };
        }
    }
}

/// QEMU's own standard input and output, as files.
#[derive(Debug)]
pub struct Stdio {
    input: usize,
    output: usize,
}

impl Stdio {
    /// Opens both; `None` if the host refuses.
    pub fn open() -> Option<Self> {
        // ":tt" is the console by definition; as a file it is standard input
        // when opened to read, and standard output when opened to write.
        let name = c":tt";
        let open = |mode| {
            let block = [name.as_ptr() as usize, mode, name.count_bytes()];
            // SAFETY: SYS_OPEN takes a zero-terminated name, a mode and the
            // name's length, and only reads them.
            let handle = unsafe { syscall(nr::OPEN, &block) };
            (handle != usize::MAX).then_some(handle)
        };
        Some(Self {
            input: open(nr::open::R_BINARY)?,
            output: open(nr::open::W_TRUNC_BINARY)?,
        })
    }

    /// Reads available bytes, up to the length of `bytes`, and stops QEMU until
    /// there are any; returns their number, `None` at the end of the input.
    pub fn read(&mut self, bytes: &mut [u8]) -> Option<usize> {
        let block = [self.input, bytes.as_mut_ptr() as usize, bytes.len()];
        // SAFETY: SYS_READ takes a handle and a buffer's address and length, those
        // of `bytes`, and writes there.
        let missing = unsafe { syscall(nr::READ, &block) };
        bytes.len().checked_sub(missing).filter(|got| *got > 0)
    }

    /// Writes `bytes`; `false` if some were not accepted.
    pub fn write(&mut self, bytes: &[u8]) -> bool {
        let block = [self.output, bytes.as_ptr() as usize, bytes.len()];
        // SAFETY: SYS_WRITE takes a handle and a buffer's address and length,
        // those of `bytes`, and only reads them.
        unsafe { syscall(nr::WRITE, &block) == 0 }
    }
}
