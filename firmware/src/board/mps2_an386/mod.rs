//! The emulated board: QEMU's `mps2-an386`, a 25 MHz Cortex-M4F.
//!
//! | function       | device                       | interrupt      |
//! |----------------|------------------------------|----------------|
//! | control link   | CMSDK UART0                  | 0 RX, 1 TX     |
//! | servo bus      | CMSDK UART1                  | 2 RX, 3 TX     |
//! | transparent port | CMSDK UART2                | 4 RX, 5 TX     |
//! | clock          | CMSDK TIMER0                 | not used       |
//! | alarm, stopwatch (QEMU has no DWT counter) | CMSDK TIMER1 | 9  |
//! | tick           | no device                    | 31, by software |
//! | link, log      | no device                    | 30, by software |
//! | watchdog       | CMSDK APB watchdog           | the non-maskable one |
//! | lockstep, with the bytes of link, bus and port | standard input and output, by semihosting | |
//! | log            | semihosting console          |                |
//! | settings       | memory ([`flash`])           |                |
//! | servos' supply | lines of the log ([`supply`]) |               |
//!
//! The UARTs carry bytes where time is real, or slower than that; [`lockstep`] describes
//! the path of bytes there.
//!
//! QEMU has no GPIO here, so the direction pin of the servo bus only exists in
//! the program; the virtual bus keeps the directions apart by itself.
//!
//! # Running it
//!
//! ```text
//! qemu-system-arm -machine mps2-an386 -nographic -monitor none \
//!     -kernel <image> -serial <link> -serial <bus> -serial <client> \
//!     -chardev file,id=log,path=<log> \
//!     -semihosting-config enable=on,target=native,chardev=log,arg=armbridge[,arg=lockstep]
//! ```
//!
//! Link, bus and client are chardevs such as `unix:PATH` or `tcp:127.0.0.1:PORT`, to
//! which QEMU connects. The log is a stream of defmt frames in rzCOBS encoding,
//! to be decoded with the image's ELF file. Without `arg=lockstep` time is real,
//! or with `arg=slow=N` N times slower, for a bus with delays;
//! see [`lockstep`] for the other case. `-icount shift=3,sleep=off` may be added
//! in lockstep and makes measured computing times repeatable too.
//!
//! # End
//!
//! The program ends as on a real board: see [`crate::crash`]. Its sockets stay open through the
//! reset. In lockstep the bench could not follow a reset, so a panic or a fault
//! leaves QEMU, after the stop sequence, with exit code
//! [`semihosting::EXIT_PANIC`] or [`semihosting::EXIT_FAULT`]. Neither is there a
//! stop sequence at boot, which would come at no time of the bench's, nor a
//! [`watchdog`]. A bench that goes away gives [`semihosting::EXIT_NO_BENCH`].
//!
//! A fault in the hard fault's own handler locks the processor up, which is the end
//! of QEMU: it aborts.
//!
//! `arg=provoke=KIND@MS` injects a failure; see [`fault_injection`].

pub mod bus;
pub mod clock;
pub mod crash;
pub mod fault_injection;
pub mod flash;
pub mod interrupt;
pub mod link;
pub mod lockstep;
pub mod log;
pub mod real_time;
pub mod semihosting;
pub mod supply;
mod timer;
pub mod uart;
pub mod watchdog;

use uart::Uart;

/// Clock of core, timers and UARTs in MHz.
pub const CLOCK_MHZ: u32 = 25;

/// Control link.
pub static LINK: Uart = Uart::new(0x4000_4000);
/// Servo bus.
pub static BUS: Uart = Uart::new(0x4000_5000);
/// Transparent port.
pub static CLIENT: Uart = Uart::new(0x4000_6000);
