//! Execution times of the firmware, in processor cycles (16 MHz, 62.5 ns each).
//!
//! The figures belong to one compilation of the firmware (avr-gcc, `-O2`), the
//! one whose exchanges are recorded, and are exact for it except for branches that
//! differ by a few cycles. The cost of a division depends on its operands, as
//! on the processor. Another compiler changes the figures by a few per cent. They
//! determine latencies and the order of two close events, never the content
//! of a reply. While bytes arrive back to back the receive handler leaves the
//! main loop 16 cycles in 160, so a change of a few cycles shifts a reply by a byte time.
//!
//! The phases of the bit clock and of the converter's clock at power-up, and the
//! moment at which a receiver has a byte, were fitted to the recording.

/// Processor cycles per microsecond.
pub(super) const PER_US: u64 = 16;

/// From power-up to the first turn of the main loop, which begins with a tick.
/// Five of these cycles are spent 19 ms later, when the LED is switched off.
pub(super) const BOOT: u64 = 5_417;
/// One idle turn of the main loop.
pub(super) const TURN: u64 = POLL_TO_TRANSMIT + TRANSMIT_TO_POLL;
/// Additional cost of a turn once a START has been received.
pub(super) const TURN_STARTED: u64 = 5;
/// Additional cost of a turn while a CYCLE waits for its reply.
pub(super) const TURN_CYCLE_PENDING: u64 = 12;
/// Main loop turns between two timer ticks (the tick takes one more).
pub(super) const TURNS_PER_TICK: u8 = 6;

/// From the poll for a message to the tick, in a turn that has one.
pub(super) const POLL_TO_TICK: u64 = 54;
/// From the tick to the poll of the converter.
pub(super) const TICK_TO_CONVERTER: u64 = 15;
/// From the poll of the converter to the transmitter.
pub(super) const CONVERTER_TO_TRANSMIT: u64 = 35;
/// From the poll of the converter to the start of a conversion due in this tick.
pub(super) const CONVERTER_TO_CONVERSION: u64 = 44;
/// The same for a conversion of the temperature.
pub(super) const CONVERTER_TO_TEMPERATURE: u64 = 35;
/// The same for a conversion due in an earlier tick.
pub(super) const CONVERTER_TO_LATE_CONVERSION: u64 = 25;
/// From the poll for a message to the transmitter, without tick.
pub(super) const POLL_TO_TRANSMIT: u64 = 61;
/// From the transmitter to the poll for a message, with nothing to send.
pub(super) const TRANSMIT_TO_POLL: u64 = 32;
/// Additional cost while the last byte has not left the transmitter's buffer.
pub(super) const TRANSMIT_LAST: u64 = 2;
/// From the transmitter to the poll for a message, with a byte for which it has no room.
pub(super) const TRANSMIT_FULL_TO_POLL: u64 = 30;
/// From the transmitter to the poll for a message, with a byte sent.
pub(super) const TRANSMIT_BYTE_TO_POLL: u64 = 55;
/// From the check for room to the write of a byte.
pub(super) const TRANSMIT_TO_SEND: u64 = 19;
/// From the check for room to the check of the transmitter-empty flag.
pub(super) const TRANSMIT_TO_EMPTY: u64 = 6;
/// Switching the bus driver on.
pub(super) const DRIVER_ON: u64 = 6;
/// From the detection of an empty transmitter to the bus driver off: a pause of the
/// firmware.
pub(super) const DRIVER_OFF: u64 = 290;
/// From the bus driver off to the poll for a message.
pub(super) const RELEASE_TO_POLL: u64 = 28;

/// Tick: a PWM of a sync write is applied.
pub(super) const TICK_SYNC_PWM: u64 = 40;
/// Tick during a delay of START or CYCLE: its counter.
pub(super) const TICK_DELAY: u64 = 3;
/// Tick without a running conversion: the check whether one is due.
pub(super) const TICK_NOT_CONVERTING: u64 = 10;
/// Tick: the next conversion becomes due.
pub(super) const TICK_DUE: u64 = 19;
/// Tick: a conversion is started.
pub(super) const TICK_CONVERT: u64 = 7;
/// Tick: a conversion of the temperature becomes due and is started.
pub(super) const TICK_TEMPERATURE: u64 = 26;
/// Control step in PWM mode.
pub(super) const CONTROL_PWM: u64 = 130;
/// Control step in position mode, moving up at a set speed.
pub(super) const CONTROL_UP: u64 = 524;
/// The same, moving down.
pub(super) const CONTROL_DOWN: u64 = 533;
/// Control step in position mode, holding.
pub(super) const CONTROL_HOLD: u64 = 535;
/// Saving while holding with the goal above the position by more than the speed.
pub(super) const HOLD_BELOW_GOAL: u64 = 4;
/// Additional cost while holding with the goal below the position.
pub(super) const HOLD_ABOVE_GOAL: u64 = 5;
/// Additional cost of dividing a negative number. Each set bit of a quotient adds one cycle.
pub(super) const DIVIDE_NEGATIVE: i64 = 21;
/// A PWM below 0 is limited.
pub(super) const LIMITED: u64 = 2;
/// Negating a negative speed.
pub(super) const SPEED_NEGATIVE: u64 = 6;
/// Control step in position mode, above the upper limit.
pub(super) const CONTROL_ABOVE: u64 = 181;
/// The same, below the lower limit.
pub(super) const CONTROL_BELOW: u64 = 192;
/// Control step with a temperature.
pub(super) const CONTROL_TEMPERATURE: u64 = 33;
/// The first position fills the whole history.
pub(super) const HISTORY_FILLED: u64 = 95;
/// The history of positions wraps to its first element.
pub(super) const HISTORY_WRAPS: u64 = 1;
/// Applying a changed PWM above 1000.
pub(super) const SET_PWM_UP: u64 = 28;
/// Applying a changed PWM below 1000.
pub(super) const SET_PWM_DOWN: u64 = 30;
/// Switching the motor off.
pub(super) const SET_PWM_OFF: u64 = 20;

/// Interrupt response and return, on top of each handler.
pub(super) const INTERRUPT: u64 = 6;
/// From the effect of a handler to its end.
pub(super) const HANDLER_RETURN: u64 = 38;
/// End-of-conversion handler.
pub(super) const CONVERTED: u64 = 28;

/// From the poll for a message to the end of one without effect.
pub(super) const ACCEPT: u64 = 127;
/// Additional cost of a START.
pub(super) const START: u64 = 11;
/// Saving of a packet that identifies the predecessor.
pub(super) const PREDECESSOR_LEARNT: u64 = 5;
/// Additional cost of a CYCLE.
pub(super) const CYCLE: u64 = 5;
/// Additional cost of a CYCLE before any START.
pub(super) const CYCLE_IGNORED: u64 = 1;
/// Additional cost of a CYCLE that waits for the predecessor.
pub(super) const CYCLE_WAITS: u64 = 25;
/// A reply with the position.
pub(super) const POSITION: u64 = 6;
/// Building a reply of one data byte.
pub(super) const REPLY: u64 = 342;
/// Each further data byte of a reply.
pub(super) const REPLY_BYTE: u64 = 31;
/// Saving of a reply without data.
pub(super) const REPLY_EMPTY: u64 = 41;
/// Saving of a reply to START, in its slot.
pub(super) const REPLY_UNSOLICITED: u64 = 6;
/// Lower bound of building a reply.
pub(super) const SHORTEST_REPLY: u64 = REPLY - REPLY_EMPTY - REPLY_UNSOLICITED;
/// Saving of the refusal of a broadcast.
pub(super) const REFUSED_BROADCAST: u64 = 1;
/// READ: fixed part.
pub(super) const READ: u64 = 104;
/// Each byte read.
pub(super) const READ_BYTE: u64 = 40;
/// Each EEPROM byte read.
pub(super) const READ_ROM_BYTE: u64 = 51;
/// A READ that is refused.
pub(super) const READ_REFUSED: u64 = 97;
/// WRITE: fixed part.
pub(super) const WRITE: u64 = 122;
/// Saving of a broadcast WRITE.
pub(super) const WRITE_BROADCAST: u64 = 9;
/// A WRITE that is refused.
pub(super) const WRITE_REFUSED: u64 = 86;
/// `SYNC_WR`: fixed part.
pub(super) const SYNC_WRITE: u64 = 217;
/// Each byte written by WRITE.
pub(super) const WRITE_BYTE: u64 = 126;
/// Each byte written by `SYNC_WR`.
pub(super) const SYNC_WRITE_BYTE: u64 = 56;
/// Additional cost of a byte of the goal.
pub(super) const GOAL_BYTE: u64 = 8;
/// Additional cost of a byte of the PWM.
pub(super) const PWM_BYTE: u64 = 15;
/// A new goal is put in force.
pub(super) const NEW_GOAL: u64 = 68;
/// A new PWM is put in force.
pub(super) const NEW_PWM: u64 = 37;
/// A new goal or PWM is out of range.
pub(super) const OUT_OF_RANGE: u64 = 34;
/// One turn of the runaway loop of a WRITE without data.
pub(super) const RUNAWAY_TURN: u64 = 65;
/// Additional cost of a turn of the main loop while a message is stuck.
pub(super) const MESSAGE_STUCK: u64 = 45;

/// Programming one EEPROM byte: 8.448 ms (data sheet, typical).
pub(super) const ROM_WRITE: u64 = 8_448 * PER_US;
/// Instructions around one EEPROM write.
pub(super) const ROM_CALL: u64 = 20;
/// From the end of one EEPROM byte to the start of the next, in a reset.
pub(super) const ROM_NEXT: u64 = 5;
/// Loading all variables from the EEPROM and starting the serial port again.
pub(super) const ROM_LOAD: u64 = 368;

/// One clock of the converter. A conversion starts on its next edge.
pub(super) const CONVERTER_CLOCK: u64 = 128;
/// From power-up to an edge of the converter's clock.
pub(super) const CONVERTER_PHASE: u64 = 82;
/// From that edge to the result. The recorded servos' converter samples its input
/// at the end; the real one does so 11 clocks (88 us) earlier.
pub(super) const CONVERT: u64 = 1_585;
/// Additional time of the first conversion after power-up.
pub(super) const CONVERT_FIRST: u64 = CONVERTER_CLOCK * 12;
