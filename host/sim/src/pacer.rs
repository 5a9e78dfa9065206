//! Pacer: keeps virtual time from running ahead of the wall clock.
//!
//! Virtual time is computed faster than it passes: 70 times by the bench, several times by
//! the emulator. In real time its user waits for the wall clock. On a busy
//! machine virtual time falls behind, and catches up as fast as it can be computed. A lag
//! beyond [`LAG_MAX`], after a suspension for example, is subtracted from the wall clock.
//! Simulation results do not depend on any of that.

use std::time::{Duration, Instant};

/// Longest lag that is caught up.
const LAG_MAX: Duration = Duration::from_millis(100);
/// Step of the wall clock: the resolution of a sleeping thread.
const STEP: Duration = Duration::from_micros(500);

/// Start of virtual time on the wall clock.
#[derive(Clone, Debug)]
pub(crate) struct Pacer {
    /// Wall-clock time of virtual time 0.
    epoch: Instant,
}

impl Pacer {
    /// Starts virtual time 0 now.
    pub(crate) fn begin() -> Self {
        Self::begin_at(Instant::now())
    }

    fn begin_at(epoch: Instant) -> Self {
        Self { epoch }
    }

    /// Waits until the wall clock is at this virtual time, to half a millisecond.
    pub(crate) fn wait(&mut self, now_us: u64) {
        let early = self.lead(now_us, Instant::now());
        if early >= STEP {
            std::thread::sleep(early);
        }
    }

    /// Lead of virtual time; moves the epoch by a lag beyond [`LAG_MAX`].
    fn lead(&mut self, now_us: u64, wall: Instant) -> Duration {
        let due = self.epoch + Duration::from_micros(now_us);
        let late = wall.saturating_duration_since(due);
        self.epoch += late.saturating_sub(LAG_MAX);
        due.saturating_duration_since(wall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_is_caught_up_and_a_suspension_is_not() {
        let ms = Duration::from_millis;
        let begun = Instant::now();
        let mut pacer = Pacer::begin_at(begun);
        assert_eq!(pacer.lead(10_000, begun + ms(4)), ms(6));
        // 30 ms behind, and ahead again.
        assert_eq!(pacer.lead(20_000, begun + ms(50)), ms(0));
        assert_eq!(pacer.lead(60_000, begun + ms(51)), ms(9));
        // An hour, less the lag that is caught up.
        let hour = ms(3_600_000);
        assert_eq!(pacer.lead(61_000, begun + ms(61) + hour), ms(0));
        assert_eq!(pacer.lead(162_000, begun + ms(61) + hour), ms(1));
    }
}
