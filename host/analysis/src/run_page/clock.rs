//! Time of ticks in s after the first one. It goes on after a reset of the board, which
//! restarts the board's clock.

/// Clock of a run.
#[derive(Debug, Default)]
pub(super) struct Clock {
    origin_us: u64,
    last_us: Option<u64>,
    /// Time at which the board was last reset.
    before_s: f64,
}

impl Clock {
    /// Advances to a tick; returns its time.
    pub(super) fn advance(&mut self, start_us: u64, period_s: f64) -> f64 {
        match self.last_us {
            None => self.origin_us = start_us,
            Some(last_us) if start_us < last_us => {
                self.before_s = self.time_s(last_us) + period_s;
                self.origin_us = start_us;
            }
            Some(_) => {}
        }
        self.last_us = Some(start_us);
        self.time_s(start_us)
    }

    /// Time of the latest tick; 0 before the first.
    pub(super) fn now_s(&self) -> f64 {
        self.last_us.map_or(0.0, |last_us| self.time_s(last_us))
    }

    /// Time of a moment of the board's clock since its last reset.
    pub(super) fn time_s(&self, at_us: u64) -> f64 {
        // An acknowledgement may refer to a moment before the first tick.
        let since_us = i128::from(at_us) - i128::from(self.origin_us);
        self.before_s + since_us as f64 * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on_after_a_reset() {
        let mut clock = Clock::default();
        let times = [5_000, 6_000, 7_000, 100, 1_100].map(|us| clock.advance(us, 1e-3));
        let expected = [0.0, 0.001, 0.002, 0.003, 0.004];
        let is_near = |(a, b): (f64, f64)| (a - b).abs() < 1e-9;
        assert!(times.into_iter().zip(expected).all(is_near), "{times:?}");
        assert!((clock.time_s(0) - 0.0029).abs() < 1e-9);
    }
}
