//! The bridge on a board: drivers, executors, boot and stop.
//!
//! Nothing here decides a torque; that is the `armbridge-shared` crate, the
//! same code that the bench runs. A board adds bytes, a pin, a clock and a way
//! to stop.
//!
//! ```text
//!  interrupt executor, highest priority          thread mode
//!  +-----------------------------------+         +-----------------------+
//!  | tasks::real_time: the tick        |  mail-  | tasks::link: the host |
//!  | poll -> decide -> publish -> feed | boxes   | tasks::client, log    |
//!  +-----------------------------------+ <-----> +-----------------------+
//!     |  woken by bus bytes and alarm                 |  USB or UART
//!   servo bus                        host, and client of the transparent port
//! ```
//!
//! | module    | what                                                     |
//! |-----------|----------------------------------------------------------|
//! | [`ring`]  | bytes from an interrupt to a task, without locks         |
//! | [`port`]  | a buffered serial port as the bus master wants it        |
//! | [`tasks`] | the loops, the same on every board                       |
//! | [`stop`]  | the stop sequence by polling, for when all else has failed |
//! | [`crash`] | how the program ends when it fails, and what is kept of it |
//! | [`settings`] | settings across resets                                |
//! | [`image_crc`] | which program this is                                 |
//! | [`stack`] | how much of the stack was ever used                      |
//! | [`board`] | what differs: one module and one binary per board        |
//!
//! There is no heap. Bytes from bus or link never lead to a panic: `bin/no-panic.rs`
//! shows it by linking. Should one happen all the same, the motors are stopped first
//! (see [`crash`]).
#![no_std]
// Wakers and signals cannot be shown, nor what holds them.
#![allow(missing_debug_implementations)]

pub mod board;
pub mod crash;
pub mod image_crc;
pub mod port;
pub mod ring;
pub mod settings;
pub mod stack;
pub mod stop;
pub mod tasks;
