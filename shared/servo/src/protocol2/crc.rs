//! CRC-16 of a packet: polynomial 0x8005, from 0, most significant bit first.
//!
//! Four bits are taken at once, from a table of 32 bytes: a board has little flash to spare, and a
//! tick has fewer than a hundred bytes.

/// Remainders of the four most significant bits.
const TABLE: [u16; 16] = {
    let mut table = [0; 16];
    let mut index = 0;
    while index < table.len() {
        let mut remainder = (index as u16) << 12;
        let mut bit = 0;
        while bit < 4 {
            remainder = if remainder & 0x8000 == 0 {
                remainder << 1
            } else {
                (remainder << 1) ^ 0x8005
            };
            bit += 1;
        }
        table[index] = remainder;
        index += 1;
    }
    table
};

/// The CRC of bytes so far, for a packet that comes piece by piece.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crc(u16);

impl Crc {
    /// That of no bytes.
    pub const fn new() -> Self {
        Self(0)
    }

    /// Adds bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            for nibble in [byte >> 4, byte & 0xF] {
                let index = (self.0 >> 12) as u8 ^ nibble;
                // It has four bits.
                let remainder = TABLE.get(usize::from(index)).copied().unwrap_or_default();
                self.0 = (self.0 << 4) ^ remainder;
            }
        }
    }

    /// The CRC.
    pub const fn value(self) -> u16 {
        self.0
    }
}

/// The CRC of these bytes.
pub fn checksum(bytes: &[u8]) -> u16 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Bit by bit, as the e-Manual defines it.
    fn bitwise(bytes: &[u8]) -> u16 {
        bytes.iter().fold(0, |crc, byte| {
            let crc = crc ^ (u16::from(*byte) << 8);
            (0..8).fold(crc, |crc, _| {
                let next = crc << 1;
                if crc & 0x8000 == 0 {
                    next
                } else {
                    next ^ 0x8005
                }
            })
        })
    }

    #[test]
    fn the_check_value_is_that_of_the_catalogue() {
        // "CRC-16/UMTS" in the catalogue of parametrised CRC algorithms.
        assert_eq!(checksum(b"123456789"), 0xFEE8);
    }

    proptest! {
        #[test]
        fn nibbles_are_bits(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            prop_assert_eq!(checksum(&bytes), bitwise(&bytes));
        }
    }
}
