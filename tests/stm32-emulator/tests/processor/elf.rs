//! ELF files of 32 bits: their parts that a boot loader would write, and files of one part.

/// Bytes and their address in flash, of each part.
pub(crate) fn parts(file: &[u8]) -> Vec<(u32, &[u8])> {
    let half = |at: usize| usize::from(u16::from_le_bytes([file[at], file[at + 1]]));
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    assert_eq!(&file[..5], b"\x7FELF\x01");
    let (table, size, count) = (word(28) as usize, half(42), half(44));
    let headers = (0..count).map(|index| table + index * size);
    let loaded = headers.filter(|header| word(*header) == 1 && word(header + 16) != 0);
    let part = |header| {
        let start = word(header + 4) as usize;
        let bytes = &file[start..start + word(header + 16) as usize];
        (word(header + 12), bytes)
    };
    loaded.map(part).collect()
}

/// A file of one part at address 0, with the entry point there that its vector table has.
pub(crate) fn file(code: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let entry = u32::from_le_bytes(code[4..8].try_into().unwrap());
    let (header, table) = (52_u32, 32_u32);
    let length = code.len() as u32;
    file.extend(b"\x7FELF\x01\x01\x01\0\0\0\0\0\0\0\0\0");
    // Executable, ARM, version 1.
    file.extend([2, 0, 40, 0, 1, 0, 0, 0]);
    // Entry, program headers, no section headers, flags (EABI 5).
    for word in [entry, header, 0, 0x0500_0000] {
        file.extend(word.to_le_bytes());
    }
    for half in [header as u16, table as u16, 1, 40, 0, 0] {
        file.extend(half.to_le_bytes());
    }
    // Loaded, offset, addresses, sizes, readable and executable, alignment.
    for word in [1, header + table, 0, 0, length, length, 5, 4] {
        file.extend(word.to_le_bytes());
    }
    file.extend(code);
    file
}
