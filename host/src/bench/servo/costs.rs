//! How long the firmware takes, in processor cycles (16 MHz, 62.5 ns each).
//!
//! The figures belong to one compilation of the firmware (avr-gcc, `-O2`),
//! counted from the machine code; another compiler moves them by a few per
//! cent. They decide latencies and which of two close events comes first,
//! never the content of a reply.

/// Processor cycles per microsecond.
pub(super) const PER_US: u64 = 16;

/// From power-up to the first turn of the main loop. The remainder modulo one
/// bit time places the serial port's bit clock, which is started just before.
pub(super) const BOOT: u64 = 5_504;
/// One idle turn of the main loop.
pub(super) const TURN: u64 = 93;
/// What a turn costs more once a START has been received.
pub(super) const TURN_ON_CHAIN: u64 = 5;
/// Main loop turns between two timer ticks (one more passes in the tick).
pub(super) const TURNS_PER_TICK: u8 = 6;

/// From looking for a message to the tick, in a turn that has one.
pub(super) const LOOK_TO_TICK: u64 = 66;
/// From the tick to feeding the transmitter.
pub(super) const TICK_TO_FEED: u64 = 64;
/// From looking for a message to feeding the transmitter, without tick.
pub(super) const LOOK_TO_FEED: u64 = 77;
/// From feeding the transmitter to looking for a message.
pub(super) const FEED_TO_LOOK: u64 = 16;
/// From the tick to looking for a message when there is nothing to send.
pub(super) const TICK_TO_LOOK: u64 = TICK_TO_FEED + FEED_TO_LOOK;

/// Handing one byte to the transmitter.
pub(super) const FEED: u64 = 20;
/// Switching the bus driver on.
pub(super) const DRIVER_ON: u64 = 6;
/// The firmware's pause before it switches the bus driver off.
pub(super) const DRIVER_OFF: u64 = 268;

/// Tick: a PWM taken from a sync write is noted.
pub(super) const TICK_SYNC_PWM: u64 = 40;
/// Tick while the chain waits: counting down.
pub(super) const TICK_DELAY: u64 = 3;
/// Tick: a conversion is started.
pub(super) const TICK_CONVERT: u64 = 26;
/// Tick while a conversion runs: this much less.
pub(super) const TICK_CONVERTING: u64 = 10;
/// Control step in PWM mode.
pub(super) const CONTROL_PWM: u64 = 114;
/// Control step in position mode, moving at a set speed.
pub(super) const CONTROL_SPEED: u64 = 512;
/// Control step in position mode, holding.
pub(super) const CONTROL_HOLD: u64 = 519;
/// Control step in position mode, outside the limits.
pub(super) const CONTROL_LIMIT: u64 = 192;
/// Control step that took a temperature.
pub(super) const CONTROL_TEMPERATURE: u64 = 45;
/// Applying a changed PWM.
pub(super) const SET_PWM: u64 = 28;

/// Interrupt response and jump, on top of each handler below.
pub(super) const INTERRUPT: u64 = 6;
/// End-of-conversion handler.
pub(super) const CONVERTED: u64 = 24;

/// From looking for a message to acting on it.
pub(super) const ACCEPT: u64 = 146;
/// Building a reply of one data byte.
pub(super) const REPLY: u64 = 347;
/// A reply that no message asked for has this much less around it.
pub(super) const REPLY_UNASKED: u64 = 32;
/// Each further data byte of a reply.
pub(super) const REPLY_BYTE: u64 = 45;
/// READ: fixed part, then each byte.
pub(super) const READ: u64 = 110;
/// Each byte read.
pub(super) const READ_BYTE: u64 = 26;
/// Each EEPROM byte read.
pub(super) const READ_ROM_BYTE: u64 = 33;
/// WRITE: fixed part.
pub(super) const WRITE: u64 = 163;
/// `SYNC_WR`: fixed part.
pub(super) const SYNC_WRITE: u64 = 247;
/// Each byte written by WRITE.
pub(super) const WRITE_BYTE: u64 = 137;
/// Each byte written by `SYNC_WR`.
pub(super) const SYNC_WRITE_BYTE: u64 = 70;
/// One turn of the loop that a WRITE without data is caught in.
pub(super) const RUNAWAY_TURN: u64 = 65;
/// A turn of the main loop costs this much more while a message is stuck.
pub(super) const STUCK: u64 = 45;

/// Programming one EEPROM byte: 8.448 ms (data sheet, typical).
pub(super) const ROM_WRITE: u64 = 8_448 * PER_US;
/// Instructions around one EEPROM write.
pub(super) const ROM_CALL: u64 = 20;
/// Loading all variables from the EEPROM and starting the serial port again.
pub(super) const ROM_LOAD: u64 = 340;

/// One clock of the converter. A conversion starts on its next edge.
pub(super) const CONVERTER_CLOCK: u64 = 128;
/// From the start of a conversion to its result. The recorded servos' converter
/// takes its input at the end; the real one does so 11.5 clocks (92 us) earlier.
pub(super) const CONVERT: u64 = CONVERTER_CLOCK * 13;
/// The first conversion after power-up takes this much longer.
pub(super) const CONVERT_FIRST: u64 = CONVERTER_CLOCK * 12;
