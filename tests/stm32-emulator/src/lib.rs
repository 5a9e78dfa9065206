//! An emulator of STM32F4 boards: it executes a firmware image, unmodified, instruction by
//! instruction, with the peripherals that the image uses, a servo bus and a USB host.
//!
//! It shows the behaviour of an image on the wire, on its pins and over USB, from
//! reset on, with exact instruction counts and the times of the chip's clocks. It is not
//! hardware: its peripherals do what the reference manual says of them, as far as an
//! image uses them; what an image uses beyond that is reported, see
//! [`System::unmodelled`](system::System::unmodelled).
//!
//! | module        | contents                                                    |
//! |---------------|-------------------------------------------------------------|
//! | [`core`]      | the processor, a Cortex-M4F                                 |
//! | [`peripherals`] | the chip's blocks                                         |
//! | [`chip`]      | what differs between the chips, and how a board is wired    |
//! | [`system`]    | address space: memory and peripherals, and their interrupts |
//! | [`machine`]   | the processor on its system, in time; resets                |
//! | [`line`](mod@line) | the servo bus as the board sees it                          |
//! | [`usb_host`]  | a host at the USB cable                                     |
//! | [`image`]     | ELF files                                                   |
//! | [`memory`]    | how the processor reaches the system                        |
//! | [`time`]      | time                                                        |
#![forbid(unsafe_code)]

pub mod chip;
pub mod core;
pub mod image;
pub mod line;
pub mod machine;
pub mod memory;
pub mod peripherals;
pub mod system;
pub mod time;
pub mod usb_host;
