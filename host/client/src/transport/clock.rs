//! Clock of a link in wall-clock time.

use std::time::{Duration, Instant, SystemTime};

/// Counts from the opening of the link, and never goes back, even if the system's clock
/// is set.
#[derive(Debug)]
pub(super) struct Clock {
    begun: Instant,
    /// Start, in ns since 1970.
    begun_ns: u64,
}

impl Clock {
    /// Starts the clock.
    pub(super) fn start() -> Self {
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        Self {
            begun: Instant::now(),
            // A system clock before 1970 counts as 1970.
            begun_ns: since_1970.unwrap_or_default().as_nanos() as u64,
        }
    }

    /// The host's time in µs.
    pub(super) fn now_us(&self) -> u64 {
        self.begun.elapsed().as_micros() as u64
    }

    /// The taps' time in ns since 1970.
    pub(super) fn now_ns(&self) -> u64 {
        self.begun_ns + self.begun.elapsed().as_nanos() as u64
    }

    /// Duration until this time of the host's.
    pub(super) fn until(&self, at_us: u64) -> Duration {
        Duration::from_micros(at_us.saturating_sub(self.now_us()))
    }
}
