//! Virtual time, held back to the wall clock.
//!
//! A world of virtual time is computed faster than it passes: the bench 70 times, the
//! emulator several times. Who wants to live in it waits now and then until the wall
//! clock is there too. On a machine with other things to do the world falls behind, and
//! makes up for it as fast as it can be computed. Beyond [`LAG_MAX`], after a suspension
//! for example, it does not: that much is left out of the wall clock, and the world goes
//! on from where it was. Nothing in the world depends on any of that.

use std::time::{Duration, Instant};

/// Most that is made up for.
pub const LAG_MAX: Duration = Duration::from_millis(100);
/// Finest step of the wall clock: what a sleeping thread can keep.
const STEP: Duration = Duration::from_micros(500);

/// Keeps virtual time from running ahead of the wall clock.
#[derive(Clone, Debug)]
pub struct Pacer {
    /// When virtual time was 0.
    epoch: Instant,
}

impl Pacer {
    /// Virtual time 0 is at this moment.
    pub fn begin() -> Self {
        Self::begin_at(Instant::now())
    }

    fn begin_at(epoch: Instant) -> Self {
        Self { epoch }
    }

    /// Waits until the wall clock is at this virtual time, to half a millisecond.
    pub fn wait(&mut self, now_us: u64) {
        let early = self.look(now_us, Instant::now());
        if early >= STEP {
            std::thread::sleep(early);
        }
    }

    /// How far virtual time is ahead; forgives what it is too far behind.
    fn look(&mut self, now_us: u64, wall: Instant) -> Duration {
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
    fn a_lag_is_made_up_for_and_a_suspension_is_not() {
        let ms = Duration::from_millis;
        let begun = Instant::now();
        let mut held = Pacer::begin_at(begun);
        assert_eq!(held.look(10_000, begun + ms(4)), ms(6));
        // 30 ms behind, and ahead again.
        assert_eq!(held.look(20_000, begun + ms(50)), ms(0));
        assert_eq!(held.look(60_000, begun + ms(51)), ms(9));
        // An hour, but for what is made up for.
        let hour = ms(3_600_000);
        assert_eq!(held.look(61_000, begun + ms(61) + hour), ms(0));
        assert_eq!(held.look(162_000, begun + ms(61) + hour), ms(1));
    }
}
