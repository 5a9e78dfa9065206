//! How long the servos may take, and how long the wire must rest.
//!
//! Morpheus: recorded from the firmware, two servos. Stock: the e-Manual, where
//! it says anything; it says nothing of how long a servo thinks.

use super::super::Firmware;
use super::super::port::bytes_us;
use crate::JOINTS;

/// Idle time before a request. The servo that spoke last hears nothing that
/// begins within 28 µs of its last stop bit; 50 µs are safe in PWM mode.
pub const GUARD_US: u64 = 50;

/// Pause between SYNC_WR and CYCLE. Of two packets closer than 20 µs a servo
/// processes only the newer. On the bench none is lost with [`GAP_MIN_US`] either,
/// in two seconds of ticks of 600 µs, which slide past the servos' own loops
/// (`tests/gateway`); the rest is margin, 5 % of a tick at 1 kHz, until real
/// servos have been measured.
const GAP_US: u32 = 80;
/// The same pause where the period leaves no room for that margin.
const GAP_MIN_US: u32 = 30;

/// From the end of CYCLE to the last byte of two replies takes 310 µs, of which
/// 140 are bytes; with the first servo dead its successor waits 169 µs more
/// before it speaks. The rest, at 1 Mbaud, is reserve.
const POSITIONS_LATENCY_US: u64 = 310;
/// What of that two servos take that are both there.
const POSITIONS_TYPICAL_US: u64 = 150;

/// A ping is answered within 87 µs; the rest is reserve.
const PING_LATENCY_US: u64 = 340;

/// START is answered 4.74 ms times the id later; rounded up.
const START_SLOT_US: u64 = 5_000;

/// Longest return delay of a stock servo, 254 times 2 µs, and 300 µs for it to
/// think.
const STATUS_LATENCY_US: u64 = RETURN_DELAY_MAX_US + 300;
const RETURN_DELAY_MAX_US: u64 = 508;

/// Return delay that bring-up gives to stock servos. With the 22 µs they take
/// themselves a status packet begins 42 µs after the READ: just late enough for
/// the direction pin, which is lowered within 40.
pub const RETURN_DELAY_US: u64 = 20;
/// From READ to status packet without return delay, as measured at the wire
/// (Xevel, notes on the USB2AX).
const STATUS_US: u64 = 22;
/// How much longer it takes after a WRITE of two bytes (same source), rounded up.
const WRITE_US: u64 = 20;
/// Each millisecond a stock servo controls its motor for so long, and sends
/// nothing meanwhile (same source). It may fall before or into a status packet,
/// and into a long one several times.
const CONTROL_STEP_US: u64 = 130;
/// What a stock servo with that delay may take longer than its bytes, if those
/// take less than a millisecond.
const SHORT_STATUS_US: u64 = RETURN_DELAY_US + STATUS_US + CONTROL_STEP_US;
/// Reserve on top of that in a tick's windows.
const RESERVE_US: u64 = 50;

/// Longest recorded time of a Morpheus servo to begin an answer is 105 µs, to a
/// READ of eleven bytes; inside that pass up to 9 µs between bytes now and then.
const MORPHEUS_ANSWER_US: u64 = 150;

/// How long a servo of unknown settings may take to begin its answer.
pub const fn latency_us(firmware: Firmware) -> u32 {
    let us = match firmware {
        Firmware::Morpheus => PING_LATENCY_US,
        Firmware::Stock => STATUS_LATENCY_US,
    };
    us as u32
}

/// Bytes of a Morpheus tick: SYNC_WR, CYCLE, two positions.
const MORPHEUS_TICK_BYTES: u32 = 16 + 6 + 14;

/// How long to listen for what.
#[derive(Clone, Copy, Debug)]
pub(super) struct Windows {
    baud: u32,
}

impl Windows {
    pub(super) const fn at(baud: u32) -> Self {
        Self { baud }
    }

    pub(super) fn ping_us(self, firmware: Firmware) -> u64 {
        bytes_us(6, self.baud) + u64::from(latency_us(firmware))
    }

    pub(super) fn start_us(self, last_id: u8) -> u64 {
        (u64::from(last_id) + 1) * START_SLOT_US + bytes_us(6, self.baud)
    }

    pub(super) fn positions_us(self) -> u64 {
        bytes_us(14, self.baud) + POSITIONS_LATENCY_US
    }

    pub(super) fn position_status_us(self, is_prepared: bool) -> u64 {
        position_status_us(self.baud, is_prepared) + RESERVE_US
    }
}

/// The pause between SYNC_WR and CYCLE, if a tick's exchange may take so long.
pub(super) fn gap_us(available_us: u32, baud: u32) -> u32 {
    let roomy_us = tick_us(Firmware::Morpheus, baud, true) + (GAP_US - GAP_MIN_US);
    if available_us >= roomy_us {
        GAP_US
    } else {
        GAP_MIN_US
    }
}

/// The shortest period at which a tick's exchange with two servos, and the rest
/// after it, is sure to be over. Stock servos must be prepared: their return
/// delay is long as they come.
pub fn tick_us(firmware: Firmware, baud: u32, is_prepared: bool) -> u32 {
    let us = match firmware {
        Firmware::Morpheus => {
            bytes_us(MORPHEUS_TICK_BYTES, baud)
                + u64::from(GAP_MIN_US)
                + POSITIONS_TYPICAL_US
                + GUARD_US
        }
        Firmware::Stock => {
            let turn_us = GUARD_US + bytes_us(8, baud) + position_status_us(baud, is_prepared);
            bytes_us(14, baud) + JOINTS as u64 * turn_us + GUARD_US
        }
    };
    us as u32
}

/// From the end of a READ to the end of a stock servo's position.
fn position_status_us(baud: u32, is_prepared: bool) -> u64 {
    let position_us = bytes_us(8, baud);
    let delay_us = if is_prepared {
        SHORT_STATUS_US
    } else {
        RETURN_DELAY_MAX_US + STATUS_US + CONTROL_STEP_US
    };
    position_us + delay_us + control_steps_us(position_us)
}

/// By how much the control steps of a stock servo stretch a packet that takes so
/// long, beside the one that may precede it.
const fn control_steps_us(packet_us: u64) -> u64 {
    const SENDS_US: u32 = 1_000 - CONTROL_STEP_US as u32;
    (packet_us as u32 / SENDS_US * CONTROL_STEP_US as u32) as u64
}

/// How much longer than its bytes the answer of a servo takes that bring-up has
/// set.
pub const fn prepared_latency_us(firmware: Firmware, baud: u32) -> u32 {
    let us = match firmware {
        Firmware::Morpheus => MORPHEUS_ANSWER_US,
        // The longest answer is the whole table.
        Firmware::Stock => SHORT_STATUS_US + WRITE_US + control_steps_us(bytes_us(56, baud)),
    };
    us as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_kilohertz_at_one_megabaud_and_600_us_with_the_short_gap() {
        assert_eq!(tick_us(Firmware::Morpheus, 1_000_000, true), 590);
        assert_eq!(tick_us(Firmware::Stock, 1_000_000, true), 954);
        assert_eq!((gap_us(1_000, 1_000_000), gap_us(600, 1_000_000)), (80, 30));
        assert_eq!(tick_us(Firmware::Morpheus, 57_142, true), 6_531);
    }
}
