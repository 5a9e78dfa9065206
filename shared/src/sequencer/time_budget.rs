//! Time budget: the free time of the bus between two ticks, and the requests that fit.

use crate::servo::Query;
use crate::servo::port::byte_ns;

/// Free time of the bus, and the duration of a byte and of a reply's delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeBudget {
    /// Until the reply must be over, in µs.
    pub budget_us: u32,
    /// One byte on the wire, in ns.
    pub byte_ns: u32,
    /// From the end of a request until a servo begins its reply, at most, in µs. Of a
    /// stock servo: its return delay, 500 µs ex works, and what it needs beyond.
    pub latency_us: u32,
}

impl TimeBudget {
    /// For a bus of this speed.
    pub const fn new(budget_us: u32, baud: u32, latency_us: u32) -> Self {
        Self {
            budget_us,
            byte_ns: byte_ns(baud),
            latency_us,
        }
    }

    /// How many bytes of request and reply there is time for.
    pub fn bytes(self) -> usize {
        let speaking_us = self.budget_us.saturating_sub(self.latency_us);
        let bytes = u64::from(speaking_us) * 1_000 / u64::from(self.byte_ns.max(1));
        usize::try_from(bytes).unwrap_or(usize::MAX)
    }

    /// Whether a request and its reply are sure to be over.
    pub fn fits<const N: usize>(self, query: &Query<N>) -> bool {
        query.packet.len() + usize::from(query.reply_bytes) <= self.bytes()
    }
}
