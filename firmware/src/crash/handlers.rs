//! The handlers that end the program: panic, hard fault, the board's non-maskable
//! interrupt, and what a board ends by itself.

use super::frame::{FRAME_LEN, is_overflow, pc_address};
use super::{memory, record};
use crate::board::crash as board;
use crate::{stack, stop};
use armbridge_link::message::{End, LastEnd};
use core::panic::{Location, PanicInfo};
use core::ptr;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SCB;

/// Number of entries of [`stop_and_reset`].
static CRASHES: AtomicU32 = AtomicU32::new(0);

/// Stack in bytes that the handlers need, with a factor of three. If less is left,
/// the stack pointer is reset.
const ROOM: u32 = 2_048;

/// The number of the non-maskable interrupt among the exceptions.
const NMI: u32 = 2;

/// Switches motors off, as the first action after any reset, also at the previous speed of
/// the bus, if it was retained.
pub fn stop_first() {
    let before = memory::is_kept().then(memory::baud);
    stop::send_first(&mut board::polled_bus(), before);
}

/// Cuts the servos' supply and switches motors off first; then writes a record and a line in
/// the log, and resets. A second entry means that this failed: after the reset the program stops the motors,
/// and the first failure is reported, if its record was written.
fn stop_and_reset(cause: impl FnOnce() -> LastEnd, log: impl FnOnce(LastEnd)) -> ! {
    cortex_m::interrupt::disable();
    let earlier = CRASHES.fetch_add(1, Ordering::Relaxed);
    board::cut_supply();
    if earlier == 0 {
        board::feed_watchdog();
        stop::send(&mut board::polled_bus(), memory::baud());
    }
    if earlier < 2 {
        let end = cause();
        memory::keep(end);
        if earlier == 0 {
            log(end);
        }
        board::reset(end.cause)
    }
    board::reset(End::Software)
}

/// Ends the program for a cause that is not its own.
pub fn end(cause: End) -> ! {
    let end = || LastEnd {
        cause,
        tick: memory::tick(),
        ..LastEnd::default()
    };
    stop_and_reset(end, |end| defmt::error!("{}", end.cause))
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let cause = || {
        let place = info.location();
        LastEnd {
            cause: End::Panic,
            pc: 0,
            line: place.map_or(0, Location::line),
            place: record::tail(place.map_or("", Location::file)),
            tick: memory::tick(),
        }
    };
    stop_and_reset(cause, |_| {
        defmt::error!("{}", defmt::Display2Format(info));
    })
}

/// Panics on an unexpected exception, which is a bug.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    panic!("unexpected exception {number}")
}

/// Checks the stack pointer before the stack is used: if it points outside the stack, or
/// too near its end, it is reset.
/// Registers of the floating-point unit that are still to be saved (LSPACT in
/// FPCCR) could be saved outside the stack: they are dropped.
// SAFETY: the name is the one by which cortex-m-rt's vector table calls it, as an
// exception handler. It never returns, so the contents of the stack are not needed
// any more; the eight words of the exception are above the pointer that is kept, or
// more than `ROOM` bytes below the one that is set, if they are in the stack.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        // FPCCR.
        "ldr r1, =0xE000EF34",
        "ldr r2, [r1]",
        "bic r2, r2, #1",
        "str r2, [r1]",
        "mrs r0, msp",
        "ldr r1, =_stack_end + {room}",
        "cmp r0, r1",
        "blo 2f",
        "ldr r1, =_stack_start - {frame}",
        "cmp r0, r1",
        "bls 3f",
        "2:",
        "ldr r1, =_stack_start",
        "mov sp, r1",
        "3:",
        "mrs r1, ipsr",
        "b {fault}",
        room = const ROOM,
        frame = const FRAME_LEN,
        fault = sym fault,
    )
}

/// The event of the board that cannot be masked ([`board::NMI`]).
// SAFETY: as for the hard fault.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn NonMaskableInt() -> ! {
    core::arch::naked_asm!("b {fault}", fault = sym HardFault)
}

/// Handles a fault, or the non-maskable interrupt. `frame` is the stack pointer at its time.
extern "C" fn fault(frame: u32, exception: u32) -> ! {
    let cause = || {
        let stack = stack::bounds();
        // SAFETY: reading the fault status register changes nothing.
        let status = unsafe { (*SCB::PTR).cfsr.read() };
        let pc = pc_address(frame, status, &stack).map(|address| {
            // SAFETY: this is within the stack's memory, and aligned.
            unsafe { ptr::read_volatile(address as *const u32) }
        });
        LastEnd {
            cause: match exception {
                NMI => board::NMI,
                _ if is_overflow(frame, status, &stack) => End::StackOverflow,
                _ => End::HardFault,
            },
            pc: pc.unwrap_or(0),
            tick: memory::tick(),
            ..LastEnd::default()
        }
    };
    stop_and_reset(cause, |end| {
        defmt::error!("{} at {=u32:#x}", end.cause, end.pc);
    })
}
