//! Which program this is: a checksum of all of it that lies in flash, so that a log
//! tells which code it is of.

use armbridge_shared::link::frame::CRC;

/// The checksum of these words, as they lie in memory.
pub fn checksum(words: impl Iterator<Item = u32>) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(feature = "board")]
pub use on_board::measure;

#[cfg(feature = "board")]
mod on_board {
    use super::checksum;
    use core::ptr;

    unsafe extern "C" {
        /// The second word of the image; the first is the stack's beginning, which
        /// all programs share, and on the emulated board at no valid address.
        static __RESET_VECTOR: u32;
        /// Where the first values of variables are kept, the last of the image.
        static __sidata: u32;
        /// Where these variables begin,
        static __sdata: u32;
        /// and end.
        static __edata: u32;
    }

    /// CRC-32/ISO-HDLC from the reset vector to the end of the image. Takes some 3
    /// million instructions: it is for boot.
    pub fn measure() -> u32 {
        let words = |from: *const u32, to: *const u32| to.addr().saturating_sub(from.addr()) / 4;
        let begin = &raw const __RESET_VECTOR;
        let code = words(begin, &raw const __sidata);
        let values = words(&raw const __sdata, &raw const __edata);
        checksum((0..code + values).map(|at| {
            // SAFETY: by the linker's layout all of these words are in flash, which
            // nothing writes while this runs.
            unsafe { ptr::read_volatile(begin.wrapping_add(at)) }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_checksum_that_every_tool_computes() {
        // The check value of CRC-32/ISO-HDLC is that of nine bytes; eight of them and
        // Python's `zlib.crc32(b"12345678")`.
        let words = [*b"1234", *b"5678"].map(u32::from_le_bytes);
        assert_eq!(checksum(words.into_iter()), 0x9AE0_DAAF);
    }
}
