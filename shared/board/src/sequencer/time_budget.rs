//! Time budget: free time of the bus between two ticks, and the requests that fit.

use armbridge_servo::Query;
use armbridge_servo::port::byte_ns;

/// Free time of the bus, with the duration of a byte and of a reply's delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeBudget {
    /// Time until the end of the reply, in µs.
    pub budget_us: u32,
    /// Duration of a byte on the wire, in ns.
    pub byte_ns: u32,
    /// Longest time from the end of a request to the start of the reply, in µs. For a
    /// stock servo: its return delay, 500 µs ex works, and its processing time.
    pub latency_us: u32,
}

impl TimeBudget {
    /// A budget on a bus of this speed.
    pub const fn new(budget_us: u32, baud: u32, latency_us: u32) -> Self {
        Self {
            budget_us,
            byte_ns: byte_ns(baud),
            latency_us,
        }
    }

    /// Number of bytes of request and reply that fit.
    pub fn bytes(self) -> usize {
        let transfer_us = self.budget_us.saturating_sub(self.latency_us);
        let bytes = u64::from(transfer_us) * 1_000 / u64::from(self.byte_ns.max(1));
        usize::try_from(bytes).unwrap_or(usize::MAX)
    }

    /// Whether a request and its reply are sure to end in time.
    pub fn fits<const N: usize>(self, query: &Query<N>) -> bool {
        query.packet.len() + usize::from(query.reply_bytes) <= self.bytes()
    }
}
