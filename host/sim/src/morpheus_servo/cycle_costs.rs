//! How long the firmware takes, in processor cycles (16 MHz, 62.5 ns each).
//!
//! The figures belong to one compilation of the firmware (avr-gcc, `-O2`), the
//! one whose exchanges are recorded, and are exact for it but for branches that
//! differ by a few cycles. The cost of a division follows from its numbers, as
//! on the processor. Another compiler moves the figures by a few per cent. They
//! decide latencies and which of two close events comes first, never the content
//! of a reply. While bytes arrive back to back the receive handler leaves the
//! main loop 16 cycles in 160, so a few cycles here move a reply by a byte time.
//!
//! The phases of the bit clock and of the converter's clock at power-up, and the
//! moment when a receiver has a byte, were fitted to the recording.

/// Processor cycles per microsecond.
pub(super) const PER_US: u64 = 16;

/// From power-up to the first turn of the main loop, which begins with a tick.
/// Five of these cycles are spent 19 ms later, when the LED is switched off.
pub(super) const BOOT: u64 = 5_417;
/// One idle turn of the main loop.
pub(super) const TURN: u64 = LOOK_TO_FEED + FEED_TO_LOOK;
/// Additional cost of a turn once a START has been received.
pub(super) const TURN_ON_CHAIN: u64 = 5;
/// And this much while a CYCLE waits to be answered.
pub(super) const TURN_IN_CYCLE: u64 = 12;
/// Main loop turns between two timer ticks (one more passes in the tick).
pub(super) const TURNS_PER_TICK: u8 = 6;

/// From looking for a message to the tick, in a turn that has one.
pub(super) const LOOK_TO_TICK: u64 = 54;
/// From the tick to looking for a result of the converter.
pub(super) const TICK_TO_SAMPLE: u64 = 15;
/// From there to feeding the transmitter.
pub(super) const SAMPLE_TO_FEED: u64 = 35;
/// From there to the start of a conversion that falls due in this tick.
pub(super) const SAMPLE_TO_CONVERSION: u64 = 44;
/// The same, of the temperature.
pub(super) const SAMPLE_TO_TEMPERATURE: u64 = 35;
/// The same, when it fell due in an earlier tick.
pub(super) const SAMPLE_TO_LATE_CONVERSION: u64 = 25;
/// From looking for a message to feeding the transmitter, without tick.
pub(super) const LOOK_TO_FEED: u64 = 61;
/// From feeding the transmitter to looking for a message, with nothing to send.
pub(super) const FEED_TO_LOOK: u64 = 32;
/// Feeding takes longer when the last byte has not left the transmitter's buffer.
pub(super) const FEED_LAST: u64 = 2;
/// The same when a byte waits that the transmitter has no room for.
pub(super) const FEED_FULL_TO_LOOK: u64 = 30;
/// The same when a byte is sent.
pub(super) const FEED_BYTE_TO_LOOK: u64 = 55;
/// From looking whether there is room for a byte to handing it over.
pub(super) const FEED_TO_SEND: u64 = 19;
/// From looking for room to looking whether the transmitter has run empty.
pub(super) const FEED_TO_EMPTY: u64 = 6;
/// Switching the bus driver on.
pub(super) const DRIVER_ON: u64 = 6;
/// From feeding an empty transmitter to switching the bus driver off: the
/// firmware pauses.
pub(super) const DRIVER_OFF: u64 = 290;
/// From switching the bus driver off to looking for a message.
pub(super) const RELEASE_TO_LOOK: u64 = 28;

/// Tick: a PWM taken from a sync write is noted.
pub(super) const TICK_SYNC_PWM: u64 = 40;
/// Tick while the chain waits: counting down.
pub(super) const TICK_DELAY: u64 = 3;
/// Tick while no conversion runs: is one due?
pub(super) const TICK_NOT_CONVERTING: u64 = 10;
/// Tick: the next conversion falls due.
pub(super) const TICK_DUE: u64 = 19;
/// Tick: a conversion is started.
pub(super) const TICK_CONVERT: u64 = 7;
/// Tick: one of the temperature falls due and is started, together.
pub(super) const TICK_TEMPERATURE: u64 = 26;
/// Control step in PWM mode.
pub(super) const CONTROL_PWM: u64 = 130;
/// Control step in position mode, moving up at a set speed.
pub(super) const CONTROL_UP: u64 = 524;
/// The same, moving down.
pub(super) const CONTROL_DOWN: u64 = 533;
/// Control step in position mode, holding.
pub(super) const CONTROL_HOLD: u64 = 535;
/// Holding, with the goal above by more than the speed: this much less.
pub(super) const HOLD_BELOW_GOAL: u64 = 4;
/// Holding, with the goal below it.
pub(super) const HOLD_ABOVE_GOAL: u64 = 5;
/// Dividing a negative number. Each set bit of a quotient is one cycle, too.
pub(super) const DIVIDE_NEGATIVE: i64 = 21;
/// A PWM below 0 is limited.
pub(super) const LIMITED: u64 = 2;
/// The speed is taken without its sign.
pub(super) const SPEED_NEGATIVE: u64 = 6;
/// Control step in position mode, above the upper limit.
pub(super) const CONTROL_ABOVE: u64 = 181;
/// The same, below the lower limit.
pub(super) const CONTROL_BELOW: u64 = 192;
/// Control step that took a temperature.
pub(super) const CONTROL_TEMPERATURE: u64 = 33;
/// The first position fills the whole history.
pub(super) const HISTORY_FILLED: u64 = 95;
/// The history of positions starts again at its first place.
pub(super) const HISTORY_WRAPS: u64 = 1;
/// Applying a changed PWM above 1000.
pub(super) const SET_PWM_UP: u64 = 28;
/// Applying a changed PWM below 1000.
pub(super) const SET_PWM_DOWN: u64 = 30;
/// Switching the motor off.
pub(super) const SET_PWM_OFF: u64 = 20;

/// Interrupt response and return, on top of each handler.
pub(super) const INTERRUPT: u64 = 6;
/// The end of a handler, when its effects are there.
pub(super) const HANDLER_RETURN: u64 = 38;
/// End-of-conversion handler.
pub(super) const CONVERTED: u64 = 28;

/// From looking for a message to the end of one without effect.
pub(super) const ACCEPT: u64 = 127;
/// A START, on top of that.
pub(super) const START: u64 = 11;
/// A packet that shows a predecessor on the bus costs this much less.
pub(super) const LEARNT: u64 = 5;
/// A CYCLE.
pub(super) const CYCLE: u64 = 5;
/// One before any START costs this much more.
pub(super) const CYCLE_IGNORED: u64 = 1;
/// A CYCLE that has to wait for the predecessor.
pub(super) const CYCLE_WAITS: u64 = 25;
/// A reply with the position.
pub(super) const POSITION: u64 = 6;
/// Building a reply of one data byte.
pub(super) const REPLY: u64 = 342;
/// Each further data byte of a reply.
pub(super) const REPLY_BYTE: u64 = 31;
/// A reply without data costs this much less.
pub(super) const REPLY_EMPTY: u64 = 41;
/// Saving of a reply to START, in its slot.
pub(super) const REPLY_UNASKED: u64 = 6;
/// And of a refusal of a broadcast.
pub(super) const REFUSED_TO_ALL: u64 = 1;
/// READ: fixed part, then each byte.
pub(super) const READ: u64 = 104;
/// Each byte read.
pub(super) const READ_BYTE: u64 = 40;
/// Each EEPROM byte read.
pub(super) const READ_ROM_BYTE: u64 = 51;
/// A READ that is refused.
pub(super) const READ_REFUSED: u64 = 97;
/// WRITE: fixed part.
pub(super) const WRITE: u64 = 122;
/// A WRITE to all has this much less.
pub(super) const WRITE_TO_ALL: u64 = 9;
/// A WRITE that is refused.
pub(super) const WRITE_REFUSED: u64 = 86;
/// `SYNC_WR`: fixed part.
pub(super) const SYNC_WRITE: u64 = 217;
/// Each byte written by WRITE.
pub(super) const WRITE_BYTE: u64 = 126;
/// Each byte written by `SYNC_WR`.
pub(super) const SYNC_WRITE_BYTE: u64 = 56;
/// On top of that for a byte of the goal.
pub(super) const GOAL_BYTE: u64 = 8;
/// And for a byte of the PWM.
pub(super) const PWM_BYTE: u64 = 15;
/// A new goal is put in force.
pub(super) const NEW_GOAL: u64 = 68;
/// A new PWM is put in force.
pub(super) const NEW_PWM: u64 = 37;
/// Either of them is out of range.
pub(super) const OUT_OF_RANGE: u64 = 34;
/// One turn of the loop that a WRITE without data is caught in.
pub(super) const RUNAWAY_TURN: u64 = 65;
/// A turn of the main loop costs this much more while a message is stuck.
pub(super) const STUCK: u64 = 45;

/// Programming one EEPROM byte: 8.448 ms (data sheet, typical).
pub(super) const ROM_WRITE: u64 = 8_448 * PER_US;
/// Instructions around one EEPROM write.
pub(super) const ROM_CALL: u64 = 20;
/// From one EEPROM byte being done to the start of the next, in a reset.
pub(super) const ROM_NEXT: u64 = 5;
/// Loading all variables from the EEPROM and starting the serial port again.
pub(super) const ROM_LOAD: u64 = 368;

/// One clock of the converter. A conversion starts on its next edge.
pub(super) const CONVERTER_CLOCK: u64 = 128;
/// From power-up to an edge of that clock.
pub(super) const CONVERTER_PHASE: u64 = 82;
/// From that edge to the result. The recorded servos' converter takes its input
/// at the end; the real one does so 11 clocks (88 us) earlier.
pub(super) const CONVERT: u64 = 1_585;
/// The first conversion after power-up takes this much longer.
pub(super) const CONVERT_FIRST: u64 = CONVERTER_CLOCK * 12;
