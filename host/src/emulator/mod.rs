//! The firmware image under QEMU.
//!
//! The image is the one for QEMU's `mps2-an386`: a Cortex-M4F, the core of the
//! real board, with two serial ports that are sockets here.
//!
//! | port               | carries                                              |
//! |--------------------|------------------------------------------------------|
//! | UART0              | control link                                         |
//! | UART1              | servo bus                                            |
//! | semihosting stdio  | lockstep messages, see [`armbridge_shared::lockstep`] |
//! | semihosting console | log                                                 |
//!
//! | module     | what                                                    |
//! |------------|---------------------------------------------------------|
//! | [`qemu`]   | the process, its command line and its sockets           |
//! | [`board`]  | the emulated board in virtual time                      |
//! | [`log`]    | its defmt frames as lines                               |

pub mod board;
pub mod log;
pub mod qemu;

pub use board::EmulatedBoard;
pub use qemu::{Failure, Provocation, Qemu, QemuError, QemuOptions, Time};
