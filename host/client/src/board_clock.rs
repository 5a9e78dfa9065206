//! Clock of the board, as seen from the host.
//!
//! A record arrives later than its tick by a delay that is never negative: the offset is that of
//! the smallest delay, which drift of either clock lets grow slowly.

/// Share of the difference to a later record by which the estimate follows it: a drift of 50 ppm is
/// tracked to microseconds.
const FOLLOW: i64 = 256;

/// Offset of the board's clock from the host's in µs.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClockOffset(Option<i64>);

impl ClockOffset {
    /// Takes a tick that started at `start_us` on the board's clock, and whose record arrived at
    /// `now_us` on the host's.
    pub fn update(&mut self, now_us: u64, start_us: u64) {
        let observed = start_us as i64 - now_us as i64;
        let estimate = self.0.get_or_insert(observed);
        *estimate = observed.max(*estimate - (*estimate - observed) / FOLLOW);
    }

    /// Time on the board's clock, in µs, at this time on the host's; the same before a record has
    /// arrived.
    pub fn board_us(&self, host_us: u64) -> u64 {
        host_us.saturating_add_signed(self.0.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Delays of up to 0.9 ms and a drift of 50 ppm leave an error of some microseconds.
    #[test]
    fn delays_and_drift_are_tracked() {
        let mut clock = ClockOffset::default();
        assert_eq!(clock.board_us(7), 7);
        for tick in 0..20_000_u64 {
            let start_us = tick * 1_000;
            let delay_us = [900, 200, 50, 700, 400][(tick % 5) as usize];
            clock.update(
                5_000_000 + start_us + start_us / 20_000 + delay_us,
                start_us,
            );
        }
        let (host_us, board_us) = (5_000_000 + 20_000_000 + 1_000, 20_000_000);
        assert!(clock.board_us(host_us).abs_diff(board_us) < 60);
    }
}
