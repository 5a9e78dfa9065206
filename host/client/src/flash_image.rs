//! Contents of a board's flash, as an ELF file loads them, and their checksum.
//!
//! The firmware computes the same checksum at boot and reports it as its `image`: so a file
//! is compared with what a board runs. It covers the image from its second word on, because
//! an emulated board cannot read the first, see the firmware's `image_crc`.

use armbridge_link::crc32::checksum;

/// Largest extent of an image in flash, in bytes: that of the largest board.
const FLASH_LEN: usize = 1 << 20;

/// A byte of flash that is erased: where an image has a gap, a debug probe leaves it.
pub const ERASED: u8 = 0xFF;

/// Bytes of an image, from its beginning in flash to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlashImage {
    /// Address of the first.
    pub address: u32,
    /// The bytes, variables' initial values included.
    pub bytes: Vec<u8>,
}

impl FlashImage {
    /// The image in an ELF file, with `fill` where it has gaps. `None` if the file is no
    /// 32-bit little-endian ELF file for ARM that loads anything.
    pub fn of_elf(elf: &[u8], fill: u8) -> Option<Self> {
        /// Kind of the segments that are loaded.
        const PT_LOAD: usize = 1;
        /// The ARM architecture.
        const EM_ARM: usize = 40;

        let word = |at: usize| {
            let bytes = elf.get(at..at.checked_add(4)?)?;
            Some(u32::from_le_bytes(bytes.try_into().ok()?) as usize)
        };
        let half = |at: usize| {
            Some(usize::from(u16::from_le_bytes(
                *elf.get(at..)?.first_chunk()?,
            )))
        };
        // Class 32 bits, little endian, behind the magic bytes.
        if !elf.starts_with(b"\x7FELF\x01\x01") || half(18)? != EM_ARM {
            return None;
        }
        let (table, entry_len, entries) = (word(28)?, half(42)?, half(44)?);
        let mut loaded: Vec<(usize, &[u8])> = Vec::new();
        for entry in (0..entries).map(|entry| table + entry * entry_len) {
            let (kind, offset, address, len) = (
                word(entry)?,
                word(entry + 4)?,
                word(entry + 12)?,
                word(entry + 16)?,
            );
            if kind == PT_LOAD && len > 0 {
                loaded.push((address, elf.get(offset..offset.checked_add(len)?)?));
            }
        }
        let begin = loaded.iter().map(|(address, _)| *address).min()?;
        let mut bytes = Vec::new();
        for (address, loaded) in loaded {
            let at = address - begin;
            let end = at.checked_add(loaded.len())?;
            if end > FLASH_LEN {
                return None;
            }
            bytes.resize(bytes.len().max(end), fill);
            bytes[at..end].copy_from_slice(loaded);
        }
        Some(Self {
            address: begin.try_into().ok()?,
            bytes,
        })
    }

    /// CRC-32/ISO-HDLC from the second word on, as the board reports it.
    pub fn crc32(&self) -> u32 {
        checksum(self.bytes.get(4..).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file that loads these bytes at these addresses.
    fn elf(segments: &[(u32, &[u8])]) -> Vec<u8> {
        const HEADER_LEN: usize = 52;
        const ENTRY_LEN: usize = 32;
        let mut file = vec![0; HEADER_LEN + ENTRY_LEN * segments.len()];
        file[..6].copy_from_slice(b"\x7FELF\x01\x01");
        file[18] = 40;
        file[28] = HEADER_LEN as u8;
        file[42] = ENTRY_LEN as u8;
        file[44] = segments.len() as u8;
        for (index, (address, bytes)) in segments.iter().enumerate() {
            let offset = file.len() as u32;
            let entry = HEADER_LEN + ENTRY_LEN * index;
            for (at, value) in [
                (0, 1),
                (4, offset),
                (12, *address),
                (16, bytes.len() as u32),
            ] {
                file[entry + at..entry + at + 4].copy_from_slice(&value.to_le_bytes());
            }
            file.extend_from_slice(bytes);
        }
        file
    }

    #[test]
    fn checksum_is_of_flash_from_the_second_word_on() {
        // Segments need not be in order.
        let file = elf(&[(0x810, b"data"), (0x800, b"\0\0\0\0text")]);
        for (fill, expected) in [
            (0, b"\0\0\0\0text\0\0\0\0\0\0\0\0data"),
            (ERASED, b"\0\0\0\0text\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFFdata"),
        ] {
            let image = FlashImage::of_elf(&file, fill).unwrap();
            assert_eq!((image.address, &*image.bytes), (0x800, &expected[..]));
            assert_eq!(image.crc32(), checksum(&expected[4..]));
        }
    }

    #[test]
    fn damaged_files_are_no_images() {
        let good = elf(&[(0, b"\0\0\0\0text"), (8, b"data")]);
        for len in 0..good.len() {
            assert_eq!(FlashImage::of_elf(&good[..len], 0), None, "{len} bytes");
        }
        // For another machine: x86.
        let mut other = good.clone();
        other[18] = 3;
        assert_eq!(FlashImage::of_elf(&other, 0), None);
        // As far apart as flash and memory are.
        let apart = elf(&[(0, b"text"), (0x2000_0000, b"data")]);
        assert_eq!(FlashImage::of_elf(&apart, 0), None);
    }
}
