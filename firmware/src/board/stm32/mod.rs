//! What boards with an STM32F4 share. A board passes its instances, pins and clocks.
//!
//! | module    | content                                                           |
//! |-----------|-------------------------------------------------------------------|
//! | [`clock`] | time since boot and the tick's alarm, on a 32-bit timer           |
//! | [`oscillator`] | the crystal, and what happens without it                     |
//! | [`voltage_detector`] | stops the motors when the supply sags                  |
//! | [`watchdog`] | the independent watchdog                                       |
//!
//! Section numbers are those of the reference manual of the STM32F405, RM0090.

pub mod clock;
pub mod oscillator;
pub mod voltage_detector;
pub mod watchdog;
