//! How the program ends, and begins again: motors off, a note why, reset.

use super::bus::LastLine;
use crate::stop;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SCB;
use embassy_stm32::pac::RCC;

/// Why the program ended by itself; survives the reset in memory that nobody
/// initialises. Anything but the two values below is noise from power-up.
// SAFETY: `.uninit` is placed in RAM by cortex-m-rt's linker script, and any
// bits are an `AtomicU32`.
#[unsafe(link_section = ".uninit.LAST_END")]
static LAST_END: AtomicU32 = AtomicU32::new(0);
const PANIC: u32 = u32::from_le_bytes(*b"PANI");
const FAULT: u32 = u32::from_le_bytes(*b"FAUL");

/// The first act after any reset: motors off.
pub fn stop_first() {
    stop::send(&mut LastLine::take());
}

/// Logs why there was a reset.
pub fn report() {
    let cause = RCC.csr().read();
    // Section 7.3.21: the flags stay until they are removed.
    RCC.csr().modify(|w| w.set_rmvf(true));
    let why = match LAST_END.swap(0, Ordering::Relaxed) {
        PANIC => "panic",
        FAULT => "hard fault",
        _ if cause.wdgrstf() => "watchdog",
        _ if cause.sftrstf() => "software",
        _ if cause.porrstf() => "power-up",
        _ => "reset pin",
    };
    defmt::info!("last reset: {=str}", why);
}

fn reset(why: u32) -> ! {
    LAST_END.store(why, Ordering::Relaxed);
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    stop_first();
    defmt::error!("{}", defmt::Display2Format(info));
    reset(PANIC)
}

/// A hard fault, on a fresh stack.
pub(in crate::board) extern "C" fn fault() -> ! {
    stop_first();
    reset(FAULT)
}

/// An exception that nobody expects is a bug.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    panic!("unexpected exception {number}")
}
