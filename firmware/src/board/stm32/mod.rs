//! What boards with an STM32F4 share. A board passes its instances, pins and clocks.
//!
//! | module    | content                                                           |
//! |-----------|-------------------------------------------------------------------|
//! | [`clock`] | time since boot and the tick's alarm, on a 32-bit timer           |
//! | [`half_duplex`] | the servo bus on a USART, by DMA                            |
//! | [`polled_bus`] | the same for the stop sequence, without DMA or interrupts    |
//! | [`oscillator`] | the crystal, and what happens without it                     |
//! | [`voltage_detector`] | stops the motors when the supply sags                  |
//! | [`watchdog`] | the independent watchdog                                       |
//!
//! Section numbers are those of the reference manual of the STM32F405, RM0090.

pub mod clock;
pub mod half_duplex;
pub mod oscillator;
pub mod polled_bus;
pub mod voltage_detector;
pub mod watchdog;
