//! Peripherals of the STM32F405 and F446, as far as the images use them.
//!
//! Section numbers are those of the reference manual of the F405, RM0090; the F446's,
//! RM0390, describes the same blocks. A block answers reads and writes of its registers at
//! a time; what it will do by itself has a next time. What it does not model it counts as
//! unmodelled, and a test that runs an image asserts that nothing was.
//!
//! | module    | block                                                        |
//! |-----------|--------------------------------------------------------------|
//! | [`rcc`]   | clocks: oscillators, PLL, prescalers, gates, reset flags     |
//! | [`flash`] | flash: wait states, prefetch and caches, erasing, programming |
//! | [`gpio`]  | pins                                                         |
//! | [`timer`] | timers: counter, compare                                     |
//! | [`usart`] | USART: byte timing, errors, DMA requests                     |
//! | [`dma`]   | DMA streams                                                  |
//! | [`iwdg`]  | independent watchdog                                         |
//! | [`otg`]   | USB OTG FS, the device's side                                |
//! | [`pwr`]   | supply: voltage detector, over-drive                         |
//! | [`exti`]  | external interrupts, of which one is the voltage detector's  |

pub mod dma;
pub mod exti;
pub mod flash;
pub mod gpio;
pub mod iwdg;
pub mod otg;
pub mod pwr;
pub mod rcc;
pub mod timer;
pub mod usart;
