//! Ticks of two runs at the same times.
//!
//! The times are the ticks of the run with the longer period. The other run has its tick there,
//! if one is nearer than [`NEAR`] of its period; else angles and speeds are interpolated linearly
//! between its ticks before and after, and everything else is that of the tick before, which is
//! in force until the next. Where a tick is missing in one of them, there is no pair.

use std::iter::Peekable;

use armbridge_link::message::Record;

/// Distance of two ticks that are at the same time, in periods: more than clocks jitter.
const NEAR: f64 = 0.1;

/// Largest distance of consecutive ticks, in periods.
const CONSECUTIVE: f64 = 1.5;

/// Ticks of two runs at the same time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The time in s.
    pub time_s: f64,
    /// No time is left out since the pair before.
    pub follows: bool,
    /// The ticks of both.
    pub records: [Record; 2],
}

/// A tick with its time in s.
type Tick = (f64, Record);

/// Iterator over the pairs of two runs, in order of time.
#[derive(Debug)]
pub struct Pairs<I: Iterator<Item = Tick>> {
    /// Run with the longer period, and the other.
    slow: I,
    fast: Peekable<I>,
    is_swapped: bool,
    slow_period_s: f64,
    fast_period_s: f64,
    /// Ticks before the present time.
    slow_before_s: Option<f64>,
    fast_before: Option<Tick>,
    follows: bool,
    /// Ticks that have no counterpart, of the slow run and of the fast one.
    lonely: [usize; 2],
}

/// Pairs of two runs, whose ticks are in order and have these periods.
pub fn pairs<I: Iterator<Item = Tick>>([a, b]: [I; 2], periods_s: [f64; 2]) -> Pairs<I> {
    let is_swapped = periods_s[1] > periods_s[0];
    let (slow, fast) = if is_swapped { (b, a) } else { (a, b) };
    Pairs {
        slow,
        fast: fast.peekable(),
        is_swapped,
        slow_period_s: periods_s[usize::from(is_swapped)],
        fast_period_s: periods_s[usize::from(!is_swapped)],
        slow_before_s: None,
        fast_before: None,
        follows: true,
        lonely: [0; 2],
    }
}

impl<I: Iterator<Item = Tick>> Pairs<I> {
    /// Ticks of each run that have no counterpart, once all pairs are taken. Between two ticks
    /// of the slow run, those of the fast run need none.
    pub fn unmatched(&self) -> [usize; 2] {
        let [slow, fast] = self.lonely;
        if self.is_swapped {
            [fast, slow]
        } else {
            [slow, fast]
        }
    }

    /// Advances the fast run up to a time; `None`: to its end.
    fn advance(&mut self, to_s: Option<f64>) {
        let near_s = NEAR * self.fast_period_s;
        let before_s = self.slow_before_s.unwrap_or(f64::NEG_INFINITY);
        let is_gap = to_s.is_none_or(|to_s| to_s - before_s > CONSECUTIVE * self.slow_period_s);
        let is_due = |next: &Tick| to_s.is_none_or(|to_s| next.0 <= to_s + near_s);
        while let Some(tick) = self.fast.next_if(is_due) {
            let is_at_end = to_s.is_none() && tick.0 - before_s < self.slow_period_s - near_s;
            let is_near = to_s.is_some_and(|to_s| (tick.0 - to_s).abs() <= near_s);
            if is_gap && !is_near && !is_at_end {
                self.lonely[1] += 1;
            }
            self.fast_before = Some(tick);
        }
    }

    /// The fast run at this time.
    fn at(&mut self, time_s: f64) -> Option<Record> {
        let (before_s, before) = self.fast_before?;
        if (before_s - time_s).abs() <= NEAR * self.fast_period_s {
            return Some(before);
        }
        let (next_s, next) = self.fast.peek()?;
        let span_s = next_s - before_s;
        if span_s > CONSECUTIVE * self.fast_period_s {
            return None;
        }
        let share = ((time_s - before_s) / span_s) as f32;
        let between = |a: f32, b: f32| a + share * (b - a);
        let joints = |a: [f32; 2], b: [f32; 2]| std::array::from_fn(|j| between(a[j], b[j]));
        let mut between = before;
        between.output.angle_rad = joints(before.output.angle_rad, next.output.angle_rad);
        between.output.speed_rad_s = joints(before.output.speed_rad_s, next.output.speed_rad_s);
        Some(between)
    }
}

impl<I: Iterator<Item = Tick>> Iterator for Pairs<I> {
    type Item = Pair;

    fn next(&mut self) -> Option<Pair> {
        loop {
            let Some((time_s, slow)) = self.slow.next() else {
                self.advance(None);
                return None;
            };
            self.advance(Some(time_s));
            let gap_s = CONSECUTIVE * self.slow_period_s;
            self.follows &= self.slow_before_s.is_none_or(|s| time_s - s <= gap_s);
            self.slow_before_s = Some(time_s);
            let Some(fast) = self.at(time_s) else {
                self.lonely[0] += 1;
                self.follows = false;
                continue;
            };
            let records = if self.is_swapped {
                [fast, slow]
            } else {
                [slow, fast]
            };
            let follows = std::mem::replace(&mut self.follows, true);
            return Some(Pair {
                time_s,
                follows,
                records,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks every `period_ms` whose angle is the time, those in `missing` left out.
    fn run(period_ms: u32, count: u32, missing: &[u32]) -> Vec<Tick> {
        let ticks = (0..count).filter(|tick| !missing.contains(tick));
        ticks
            .map(|tick| {
                let time_s = f64::from(tick * period_ms) * 1e-3;
                let mut record = Record {
                    tick,
                    ..Record::NONE
                };
                record.output.angle_rad = [time_s as f32, 0.0];
                (time_s, record)
            })
            .collect()
    }

    fn compare(runs: [Vec<Tick>; 2], periods_ms: [u32; 2]) -> (Vec<Pair>, [usize; 2]) {
        let ticks = runs.map(Vec::into_iter);
        let mut pairs = pairs(ticks, periods_ms.map(|ms| f64::from(ms) * 1e-3));
        let all: Vec<_> = pairs.by_ref().collect();
        (all, pairs.unmatched())
    }

    #[test]
    fn runs_of_any_periods_have_the_same_angle_at_the_same_time() {
        for (periods, count, expected) in [
            ([1, 1], [900, 900], 900),
            ([1, 45], [901, 21], 21),
            ([45, 1], [21, 901], 21),
            ([7, 45], [200, 21], 21),
        ] {
            let runs =
                [0, 1].map(|run_index: usize| run(periods[run_index], count[run_index], &[]));
            let (all, unmatched) = compare(runs, periods);
            assert_eq!(all.len(), expected, "{periods:?}");
            for pair in &all {
                let [a, b] = pair
                    .records
                    .map(|record| f64::from(record.output.angle_rad[0]));
                assert!((a - b).abs() < 1e-6, "{periods:?}: {pair:?}");
                assert!((a - pair.time_s).abs() < 1e-6 && pair.follows);
            }
            // The run of 7 ms is longer than the other.
            let longer = if periods[0] == 7 { 65 } else { 0 };
            assert_eq!(unmatched, [longer, 0], "{periods:?}");
        }
    }

    #[test]
    fn missing_ticks_have_no_counterpart() {
        let runs = [run(1, 100, &[10, 11, 50]), run(1, 90, &[20])];
        let (all, unmatched) = compare(runs, [1, 1]);
        assert_eq!(all.len(), 86);
        assert_eq!(unmatched, [11, 3]);
        assert_eq!(all.iter().filter(|pair| !pair.follows).count(), 3);
        let (none, unmatched) = compare([run(1, 5, &[]), Vec::new()], [1, 1]);
        assert_eq!((none.len(), unmatched), (0, [5, 0]));
    }
}
