//! Identity of the program: a checksum of its image in flash, for the log.

#[cfg(feature = "board")]
pub use on_board::compute;

#[cfg(feature = "board")]
mod on_board {
    use armbridge_link::crc32::checksum_of_words;
    use core::ptr;

    unsafe extern "C" {
        /// The second word of the image; the first is the stack's beginning, which
        /// all programs share, and on the emulated board at no valid address.
        static __RESET_VECTOR: u32;
        /// Address of the initial values of variables, the last part of the image.
        static __sidata: u32;
        /// Beginning of these variables.
        static __sdata: u32;
        /// End of these variables.
        static __edata: u32;
    }

    /// CRC-32/ISO-HDLC from the reset vector to the end of the image. Takes some 3
    /// million instructions: it is for boot.
    pub fn compute() -> u32 {
        let words = |from: *const u32, to: *const u32| to.addr().saturating_sub(from.addr()) / 4;
        let begin = &raw const __RESET_VECTOR;
        let code = words(begin, &raw const __sidata);
        let values = words(&raw const __sdata, &raw const __edata);
        checksum_of_words((0..code + values).map(|at| {
            // SAFETY: by the linker's layout all of these words are in flash, which
            // nothing writes while this runs.
            unsafe { ptr::read_volatile(begin.wrapping_add(at)) }
        }))
    }
}
