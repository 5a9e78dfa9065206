//! CRC-32/ISO-HDLC, the one of zlib and Ethernet: four tables of 1 KiB in flash for
//! everything that is checked.
//!
//! Used by link frames, kept settings, the image's identity and the crash record. Four
//! tables take four bytes in one step, of some 14 instructions on a Cortex-M4: with one table
//! it is 5.5 a byte. The crate `crc`, with which the tests compare it, has one table or 16: with
//! 16 an armed millisecond takes 450 instructions more. That nothing of it is inlined keeps the
//! code small.

/// Polynomial, lowest power first.
const POLYNOMIAL: u32 = 0xEDB8_8320;

/// Remainder of each value of a byte, followed by 0 to 3 zero bytes. A `static`, not a `const`:
/// a constant is a table for each use.
static REMAINDERS: [[u32; 256]; 4] = remainders();

const fn remainders() -> [[u32; 256]; 4] {
    let mut tables = [[0; 256]; 4];
    let mut byte = 0;
    while byte < 256 {
        let mut remainder = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            remainder = (remainder >> 1) ^ ((remainder & 1) * POLYNOMIAL);
            bit += 1;
        }
        tables[0][byte] = remainder;
        byte += 1;
    }
    let mut zeros = 1;
    while zeros < 4 {
        let mut byte = 0;
        while byte < 256 {
            let before = tables[zeros - 1][byte];
            tables[zeros][byte] = (before >> 8) ^ tables[0][(before & 0xFF) as usize];
            byte += 1;
        }
        zeros += 1;
    }
    tables
}

/// The remainder after four bytes more, the first of them the lowest.
fn step(remainder: u32, word: u32) -> u32 {
    let [first, second, third, fourth] = (remainder ^ word).to_le_bytes().map(usize::from);
    let [none, one, two, three] = &REMAINDERS;
    three[first] ^ two[second] ^ one[third] ^ none[fourth]
}

/// The checksum of these bytes.
#[inline(never)]
pub fn checksum(bytes: &[u8]) -> u32 {
    let (words, rest) = bytes.as_chunks::<4>();
    let mut remainder = u32::MAX;
    for word in words {
        remainder = step(remainder, u32::from_le_bytes(*word));
    }
    for byte in rest {
        let [low, ..] = remainder.to_le_bytes();
        remainder = (remainder >> 8) ^ REMAINDERS[0][usize::from(low ^ byte)];
    }
    !remainder
}

/// The checksum of these words, as they lie in memory: low byte first.
#[inline(never)]
pub fn checksum_of_words(words: impl IntoIterator<Item = u32>) -> u32 {
    !words.into_iter().fold(u32::MAX, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crc::{CRC_32_ISO_HDLC, Crc};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_checksum_of_another_implementation(
            bytes in proptest::collection::vec(any::<u8>(), 0..300),
        ) {
            let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
            prop_assert_eq!(checksum(&bytes), crc.checksum(&bytes));
        }
    }

    #[test]
    fn it_is_the_checksum_that_every_tool_computes() {
        // The check value of CRC-32/ISO-HDLC, and Python's `zlib.crc32(b"12345678")`.
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
        let words = [*b"1234", *b"5678"].map(u32::from_le_bytes);
        assert_eq!(checksum_of_words(words), 0x9AE0_DAAF);
    }
}
