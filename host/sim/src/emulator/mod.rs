//! The firmware image under QEMU.
//!
//! The image is the one for QEMU's `mps2-an386`: a Cortex-M4F, the core of the
//! real board. The paths of its bytes depend on the time base.
//!
//! | bytes            | time is the wall clock's, or slower | lockstep              |
//! |------------------|-------------------------------------|-----------------------|
//! | control link     | UART0, a socket                     | QEMU's standard input and output |
//! | servo bus        | UART1, a socket                     | the same              |
//! | transparent port | UART2, a socket                     | the same              |
//! | lockstep         |                                     | the same, see [`armbridge_board::lockstep`] |
//! | log              | semihosting console, a socket       | semihosting console, a socket |
//!
//! In lockstep the firmware's drivers of those UARTs are bypassed, because QEMU needs
//! longer for a tick's bytes than the tick has; everything above them, including the
//! port of the bus master with its buffers and its pace, is the code that runs in
//! wall-clock time and on the board.
//!
//! | module     | contents                                                |
//! |------------|---------------------------------------------------------|
//! | [`image`]  | the image of the source tree, or a named one            |
//! | [`qemu`]   | the process, its command line and its sockets           |
//! | [`board`]  | the emulated board in virtual time                      |
//! | [`log`]    | its defmt frames as lines                               |

pub mod board;
pub mod image;
pub mod log;
pub mod qemu;

pub use board::EmulatedBoard;
pub use image::{Image, ImageError};
pub use qemu::{Failure, ProcessEnd, Provocation, Qemu, QemuError, QemuOptions, Time};
