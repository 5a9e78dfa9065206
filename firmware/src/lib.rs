//! The bridge on a board: drivers, executors, boot and stop.
//!
//! Torques are computed in the [`armbridge_board`] crate, the
//! same code that the bench runs. A board adds byte streams, a pin, a clock and the
//! emergency stop.
//!
//! ```text
//!  interrupt handler, high priority              thread mode
//!  +-----------------------------------+         +-----------------------+
//!  | tasks::RealTimeLoop: the tick     |  chan-  | tasks::link: the host |
//!  | poll -> decide -> publish -> feed | nels    | tasks::client, log    |
//!  +-----------------------------------+ <-----> +-----------------------+
//!     |  woken by bus bytes and alarm                 |  USB or UART
//!   servo bus                        host, and client of the transparent port
//! ```
//!
//! | module    | content                                                  |
//! |-----------|----------------------------------------------------------|
//! | [`ring`]  | bytes from an interrupt to a task, without locks         |
//! | [`port`]  | buffers of a UART                                        |
//! | [`tasks`] | the loops, the same on every board                       |
//! | [`handler_cell`] | state of an interrupt handler                     |
//! | [`stop`]  | the stop sequence by polling, after a failure            |
//! | [`crash`] | crash handling and crash record                          |
//! | [`settings`] | persistent settings                                   |
//! | [`image_crc`] | identity of the program                               |
//! | [`stack`] | high-water mark of the stack                             |
//! | `stack_guard` | no access below the stack                            |
//! | [`board`] | drivers: one module and one binary per board             |
//!
//! There is no heap. Bytes from bus or link never lead to a panic: `bin/no-panic`
//! proves it by linking. On a panic the motors are stopped first
//! (see [`crash`]).
#![no_std]
// Wakers and signals have no `Debug`, nor have the types that contain them.
#![allow(missing_debug_implementations)]

pub mod board;
pub mod crash;
pub mod handler_cell;
pub mod image_crc;
pub mod port;
pub mod ring;
pub mod settings;
pub mod stack;
#[cfg(feature = "board")]
pub mod stack_guard;
pub mod stop;
pub mod tasks;
