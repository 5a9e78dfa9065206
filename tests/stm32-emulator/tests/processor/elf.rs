//! Loads an ELF file of 32 bits: the parts that a boot loader would write.

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
