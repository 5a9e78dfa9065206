//! CRC unit (section 4): CRC-32 of words, polynomial `0x04C1_1DB7`, not reflected.

/// The unit.
#[derive(Clone, Debug)]
pub struct Crc {
    value: u32,
    scratch: u8,
}

impl Default for Crc {
    fn default() -> Self {
        Self {
            value: u32::MAX,
            scratch: 0,
        }
    }
}

impl Crc {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x0 => Some(self.value),
            0x4 => Some(self.scratch.into()),
            0x8 => Some(0),
            _ => None,
        }
    }

    /// Writes a register; `None` if there is none.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x0 => self.push(value),
            0x4 => self.scratch = value as u8,
            0x8 if value & 1 != 0 => self.value = u32::MAX,
            0x8 => {}
            _ => return None,
        }
        Some(())
    }

    fn push(&mut self, word: u32) {
        self.value ^= word;
        for _ in 0..32 {
            let carry = self.value >> 31 != 0;
            self.value <<= 1;
            if carry {
                self.value ^= 0x04C1_1DB7;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_has_the_known_crc() {
        let mut crc = Crc::default();
        assert_eq!(crc.write(0, 0), Some(()));
        // CRC-32/MPEG-2 of four zero bytes.
        assert_eq!(crc.read(0), Some(0xC704_DD7B));
    }
}
