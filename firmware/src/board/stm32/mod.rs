//! Code shared by boards with an STM32F4. A board's [`wiring`] has its instances, pins and clocks.
//!
//! | module    | content                                                           |
//! |-----------|-------------------------------------------------------------------|
//! | [`wiring`] | constants of a board: crystal, servo bus, pins                   |
//! | [`start`] | the program: from reset to the executor, and its tasks            |
//! | [`clock_tree`] | clocks of core, buses and USB                                |
//! | [`oscillator`] | the crystal, and what happens without it                     |
//! | [`pin`]   | a pin by its registers                                            |
//! | [`time`]  | the tick in its interrupt, and its stopwatch                      |
//! | [`clock`] | time since boot and the tick's alarm, on a 32-bit timer           |
//! | [`bus`]   | the servo bus of the board                                        |
//! | [`half_duplex`] | a servo bus on a USART, by DMA                              |
//! | [`baud`]  | baud rate of a USART                                              |
//! | [`polled_bus`] | the same for the stop sequence, without DMA or interrupts    |
//! | [`usb`]   | control link and transparent port                                 |
//! | [`flash`] | memory of settings                                                |
//! | [`crash`] | cause of a reset, and the reset itself                            |
//! | [`voltage_detector`] | stops the motors when the supply sags                  |
//! | [`watchdog`] | the independent watchdog                                       |
//!
//! Section numbers are those of the reference manual of the STM32F405, RM0090.
//!
//! # Priorities
//!
//! | priority | handler                                                   |
//! |----------|-----------------------------------------------------------|
//! | 0        | the bus (its USART): some 35 instructions, four times in a tick of 1 ms; a supply that sags (PVD), which ends the program |
//! | 1        | the tick (TIM5): three times in it                        |
//! | 3        | USB (`OTG_FS`); embassy's timer (TIM2), for the LED         |
//! | thread   | link, log over RTT, LED                                   |
//!
//! The bus is above the tick because a servo may speak 45 µs after the last stop bit, and
//! the tick computes for longer: the handler lowers the direction pin. Its bytes need no core,
//! DMA moves them. USB is below the tick because the length
//! of its handler depends on the host, and a packet that waits is held by the controller.
//!
//! # Settings
//!
//! Boot prepares the memory of settings ([`flash`]) after the stop sequence and before the
//! watchdog has its short period, since erasing a sector takes 1 to 2 s.
//!
//! # Stop
//!
//! Every failure ends in the stop sequence on the bus, sent by polling: a
//! panic and a hard fault send it and reset; after any reset, the watchdog's
//! included, it is the first action of the program. [`crate::crash`] has the
//! times. The output for the servos' supply goes low before that; during a reset it floats,
//! which is off as well.
//!
//! The emergency stop is a switch between its pin and ground that is closed in normal
//! use: pressed, or with a wire broken or unplugged, it is open and the pin is
//! pulled up by the chip. It is polled at least every [`time::STOP_LOOK_US`]. Without a
//! switch: a wire from the pin to ground.
//!
//! # Watchdog
//!
//! The independent [`watchdog`] runs from the end of the
//! first stop sequence on, with a long period for the boot. Then it is fed by the tick alone, at
//! the end of each good tick and of each step of bring-up. It cannot be stopped; a program halted
//! by a debugger is reset by it. See [`WATCHDOG_US`](crate::crash::WATCHDOG_US).

pub mod baud;
pub mod bus;
pub mod clock;
pub mod clock_tree;
pub mod crash;
pub mod flash;
pub mod half_duplex;
pub mod oscillator;
pub mod pin;
pub mod polled_bus;
pub mod start;
pub mod time;
pub mod usb;
pub mod voltage_detector;
pub mod watchdog;
pub mod wiring;
