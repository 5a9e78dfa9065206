//! How long the servos may take, and how long the wire must rest.
//!
//! What a firmware's servos take is with their protocol; here it is asked for by
//! [`Firmware`].

use super::super::Firmware;
use super::super::dispatch::with_protocol;
use super::super::exchange::{Exchange, Readiness};
use super::super::port::bytes_us;

pub use super::super::exchange::GUARD_US;
pub use super::super::protocol1::RETURN_DELAY_US;

/// How long a servo of unknown settings may take to begin its answer.
pub const fn latency_us(firmware: Firmware) -> u32 {
    with_protocol!(firmware, P => P::LATENCY_US)
}

/// How much longer than its bytes the answer of a servo takes that bring-up has
/// set.
pub fn prepared_latency_us(firmware: Firmware, baud: u32) -> u32 {
    with_protocol!(firmware, P => P::prepared_latency_us(baud))
}

/// The shortest period at which a tick's exchange with two servos, and the rest
/// after it, is sure to be over. It is longer with stock servos that are not
/// prepared: their return delay is long as they come.
pub fn tick_us(firmware: Firmware, baud: u32, readiness: Readiness) -> u32 {
    with_protocol!(firmware, P => P::tick_us(baud, readiness))
}

/// How long to listen for the answer to a ping.
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
    fn stock_servos_that_have_let_go_answer_as_soon_as_before() {
        let stock = |readiness| tick_us(Firmware::Stock, 1_000_000, readiness);
        assert_eq!(stock(Readiness::Unknown), 2_050);
        assert_eq!(stock(Readiness::Released), 1_074);
    }
}
