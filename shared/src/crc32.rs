//! CRC-32/ISO-HDLC, the one of zlib and Ethernet: one table of 1 KiB in flash for
//! everything that is checked.
//!
//! Used by link frames, kept settings, the image's identity and the crash record.
//! The table makes it eight times as fast as without; that nothing of it is inlined
//! keeps the code small.

use crc::{CRC_32_ISO_HDLC, Crc};

/// A `static`, not a `const`: a constant is a table for each use.
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The checksum of these bytes, four a turn: firmware is built without unrolling loops.
#[inline(never)]
pub fn checksum(bytes: &[u8]) -> u32 {
    let (words, rest) = bytes.as_chunks::<4>();
    let mut digest = CRC.digest();
    for word in words {
        digest.update(word);
    }
    digest.update(rest);
    digest.finalize()
}

/// The checksum of these words, as they lie in memory: low byte first.
#[inline(never)]
pub fn checksum_of_words(words: impl IntoIterator<Item = u32>) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_checksum_that_every_tool_computes() {
        // The check value of CRC-32/ISO-HDLC, and Python's `zlib.crc32(b"12345678")`.
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
        let words = [*b"1234", *b"5678"].map(u32::from_le_bytes);
        assert_eq!(checksum_of_words(words), 0x9AE0_DAAF);
    }
}
