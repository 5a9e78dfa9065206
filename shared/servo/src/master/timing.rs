//! Response times of the servos, and idle time of the bus.
//!
//! The times of each firmware are with its protocol; these functions select them by
//! [`Firmware`].

use super::super::Firmware;
use super::super::dispatch::with_protocol;
use super::super::exchange::{Exchange, Readiness};
use super::super::port::bytes_us;

pub use super::super::exchange::GUARD_US;
pub use super::super::protocol1::{CONTROL_STEP_US, RETURN_DELAY_US};

/// Longest time in µs until a servo of unknown settings begins its reply.
pub const fn latency_us(firmware: Firmware) -> u32 {
    with_protocol!(firmware, P => P::LATENCY_US)
}

/// Longest time in µs that a reply to a request takes beyond its bytes: on a slow bus the
/// control steps of a stock servo interrupt it. A servo that bring-up has set `answers_soon`.
pub fn reply_latency_us(firmware: Firmware, baud: u32, answers_soon: bool) -> u32 {
    with_protocol!(firmware, P => P::reply_latency_us(baud, answers_soon))
}

/// Idle time in µs before a request to the servo that sent last.
pub fn same_servo_guard_us(firmware: Firmware) -> u64 {
    with_protocol!(firmware, P => P::SAME_SERVO_GUARD_US)
}

/// Shortest period in µs in which a tick's exchange with two servos, and the idle time
/// after it, is sure to end. It is longer with stock servos that are not prepared: their
/// factory return delay is long.
pub fn tick_us(firmware: Firmware, baud: u32, readiness: Readiness) -> u32 {
    with_protocol!(firmware, P => P::tick_us(baud, readiness))
}

/// Receive window in µs of the reply to a ping.
pub(super) fn ping_window_us(firmware: Firmware, baud: u32) -> u64 {
    bytes_us(firmware.pong_bytes().into(), baud) + u64::from(latency_us(firmware))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_kilohertz_at_one_megabaud_and_600_us_with_the_short_gap() {
        let prepared = |firmware, baud| tick_us(firmware, baud, Readiness::Prepared);
        assert_eq!(prepared(Firmware::Morpheus, 1_000_000), 590);
        assert_eq!(prepared(Firmware::Stock, 1_000_000), 954);
        assert_eq!(prepared(Firmware::Morpheus, 57_142), 6_531);
    }

    #[test]
    fn a_reply_of_a_stock_servo_takes_longer_on_a_slow_bus() {
        let stock = |baud, soon| reply_latency_us(Firmware::Stock, baud, soon);
        assert_eq!([true, false].map(|soon| stock(1_000_000, soon)), [192, 808]);
        // 56 bytes last 9.8 ms, with eleven control steps.
        assert_eq!(
            [true, false].map(|soon| stock(57_142, soon)),
            [1_622, 2_238]
        );
    }

    #[test]
    fn released_stock_servos_keep_their_short_return_delay() {
        let stock = |readiness| tick_us(Firmware::Stock, 1_000_000, readiness);
        assert_eq!(stock(Readiness::Unknown), 2_050);
        assert_eq!(stock(Readiness::Released), 1_074);
    }
}
