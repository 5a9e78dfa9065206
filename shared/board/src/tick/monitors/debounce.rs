//! Debounce: times as numbers of ticks, and ticks in a row.
//!
//! Periods reach from 600 µs to 100 ms, where some times are shorter than a
//! tick. So every rule also has a least number of ticks, to rule out
//! a coincidence.

/// Number of ticks in which a time passes, at least `least`.
pub(super) const fn ticks(time_us: u32, period_us: u32, least: u32) -> u32 {
    let passed = time_us.div_ceil(period_us);
    if passed > least { passed } else { least }
}

/// Number of consecutive ticks in which a condition has held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::tick) struct Debounce(u32);

impl Debounce {
    /// Counts a tick in which the condition holds, or restarts. True from the `limit`-th
    /// consecutive tick on.
    pub(in crate::tick) fn count(&mut self, is_so: bool, limit: u32) -> bool {
        self.0 = if is_so { self.0.saturating_add(1) } else { 0 };
        self.0 >= limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_never_fewer_ticks_than_it_takes() {
        let of_10_ms = [600, 1_000, 1_500, 45_000, 100_000].map(|period| ticks(10_000, period, 2));
        assert_eq!(of_10_ms, [17, 10, 7, 2, 2]);
    }

    #[test]
    fn a_break_begins_anew() {
        let mut row = Debounce::default();
        let noted = [true, true, false, true, true, true, true].map(|is_so| row.count(is_so, 3));
        assert_eq!(noted, [false, false, false, false, false, true, true]);
    }
}
