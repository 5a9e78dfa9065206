//! The boards, as build script and gate must know them. Both include this file.

/// A board.
#[derive(Clone, Copy, Debug)]
pub struct BoardRow {
    /// Name of its image, its program and its feature.
    pub name: &'static str,
    /// Its chip, as probe-rs names it; none for the emulated board.
    pub chip: Option<&'static str>,
    /// Address of its flash.
    pub flash_origin: u32,
    /// Length of the program's flash in kB of 1,024 bytes; settings are in the two sectors
    /// after it, of 128 kB each, which only boot erases.
    pub program_kib: u32,
}

/// All boards, the default first.
pub const BOARDS: &[BoardRow] = &[
    BoardRow {
        name: "feather-f405",
        chip: Some("STM32F405RGTx"),
        flash_origin: 0x0800_0000,
        program_kib: 768,
    },
    BoardRow {
        name: "nucleo-f446ze",
        chip: Some("STM32F446ZETx"),
        flash_origin: 0x0800_0000,
        program_kib: 256,
    },
    // Cut to the size of the first, so that an image that fits the one fits the other.
    BoardRow {
        name: "mps2-an386",
        chip: None,
        flash_origin: 0,
        program_kib: 768,
    },
];
