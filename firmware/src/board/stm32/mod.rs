//! What boards with an STM32F4 share. A board passes its instances, pins and clocks.
//!
//! | module    | content                                                           |
//! |-----------|-------------------------------------------------------------------|
//! | [`clock`] | time since boot and the tick's alarm, on a 32-bit timer           |
//!
//! Section numbers are those of the reference manual of the STM32F405, RM0090.

pub mod clock;
