//! How the program ends: motors off, a line in the log, an exit code.

use super::bus::LastLine;
use super::semihosting::{self, EXIT_FAULT, EXIT_PANIC};
use crate::stop;
use core::panic::PanicInfo;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    stop::send(&mut LastLine);
    defmt::error!("{}", defmt::Display2Format(info));
    semihosting::exit(EXIT_PANIC)
}

/// A hard fault, on a fresh stack.
pub(in crate::board) extern "C" fn fault() -> ! {
    stop::send(&mut LastLine);
    defmt::error!("hard fault");
    semihosting::exit(EXIT_FAULT)
}

/// An exception that nobody expects is a bug.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    panic!("unexpected exception {number}")
}
