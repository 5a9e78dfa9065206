//! Crash handling: motors off, a record of the cause, and a reset.
//!
//! A servo obeys its last PWM for ever, so a program that fails first sets the output for
//! the servos' supply low, and sends the [stop sequence](crate::stop), by polling. Then it
//! records the cause ([`memory`]), and resets the processor. A failure in between
//! is a reset too, and the first action of the program after any reset is the
//! stop sequence again.
//!
//! ```text
//!  panic ---------+   supply off,
//!  hard fault ----+--> stop sequence --> record --> log --> reset --+
//!  crystal lost --+     |                                           |
//!  supply sags ---+     | on a failure: reset at once, or           |
//!  watchdog's NMI-+     | the watchdog's                            |
//!    (emulator)         |                                           |
//!  watchdog (board) --+ |                                           |
//!  brown-out ---------+-+-------------------------------------------+
//!  reset pin ---------+                                             v
//!        stop sequence --> record read, reported --> watchdog on --> bridge
//! ```
//!
//! # Bounds
//!
//! From the event to the last bit of the stop sequence at 1 Mbaud, in ms of the
//! board's time. Those of the real board are computed, not measured on one; its image, executed
//! on an emulated chip, takes 8.4 for the sequence and 2.3 for the boot.
//!
//! | event                         | emulated board    | real board              |
//! |-------------------------------|-------------------|-------------------------|
//! | panic, hard fault, overflow   | 8: sequence       | 10: sequence            |
//! | crystal lost, supply sags     |                   | 10: sequence            |
//! | the same, and ending fails    | 16: twice         | 23: sequence, boot, sequence |
//! | the same, and locks up        | QEMU gives up     | 317: watchdog, boot, sequence |
//! | hang: no good tick            | 170: watchdog, sequence | 317: watchdog, boot, sequence |
//! | brown-out, reset pin          |                   | 16 from its end: chip, boot, sequence |
//!
//! | part      | duration                                                     |
//! |-----------|--------------------------------------------------------------|
//! | sequence  | 7.1 ([`SEQUENCE_US`](crate::stop::SEQUENCE_US)) and the time of polling; on the real board up to 10: its pauses are counted loops, of three to five cycles a turn |
//! | watchdog  | 161.5 ([`WATCHDOG_US`]); on the real board 110 to 304, with its oscillator |
//! | boot      | 3: 26 kB of variables are cleared and copied at 16 MHz       |
//! | chip      | 3 until it releases its own reset (data sheet, section 5.3.5) |
//!
//! On a slower bus the sequence takes longer, see [`crate::stop`], and
//! after a reset it is sent both at the speed before and at 1 Mbaud. Ending feeds
//! the watchdog once, so that at any speed at which servos are found it is not cut
//! off.
//!
//! While the supply is too low and while a reset lasts nothing can be sent, and a
//! servo that still has power obeys its last command. Only a switch in the servos'
//! supply prevents that: a relay at that output, which opens in all of these cases, or one
//! within reach.
//!
//! The supply is cut before the sequence, which needs 7 ms and a servo that listens. The
//! sequence is sent all the same: a contact opens after some ms, and there may be none.
//!
//! | module     | content                                                  |
//! |------------|----------------------------------------------------------|
//! | [`memory`] | memory that is retained through a reset                  |
//! | [`record`] | the end of the program, as words in that memory          |
//! | [`frame`]  | exception frame on the stack                             |
//!
//! A board adds a bus line for polling, the output for the supply, its watchdog, the cause of
//! the reset, and the reset itself.

pub mod frame;
#[cfg(feature = "board")]
mod handlers;
pub mod memory;
pub mod record;

use armbridge_board::bridge::limits::PERIOD_MAX_US;

#[cfg(feature = "board")]
pub use handlers::{end, stop_first};

/// The watchdog's period in µs: without a good tick for that time, it resets the
/// board.
///
/// Steps of bring-up are at most 60 ms apart. The real board's watchdog counts
/// with an oscillator of nominally 32 kHz, 17 to 47 kHz in fact, and must outlast
/// the longest tick by 10 ms at 47 kHz. The emulated board's has the same period.
pub const WATCHDOG_US: u32 = {
    let longest_us = if PERIOD_MAX_US > 60_000 {
        PERIOD_MAX_US
    } else {
        60_000
    };
    (longest_us + 10_000) / 32 * 47
};
