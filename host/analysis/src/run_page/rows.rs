//! Values of a run over time in bounded memory: one row for some consecutive ticks.
//!
//! All rows have the same number of ticks. When there are too many rows, neighbours are
//! merged, so that a short run keeps every tick and an hour is as large as half a minute.

/// Values kept of each quantity: all of 16 s at 1 kHz. Twenty quantities take 0.9 MB in the
/// page.
const VALUES_MAX: usize = 16_384;

/// Values that a row keeps of its ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    /// The lowest and the highest value: no peak is lost.
    Extremes,
    /// The values of the first tick: a sequence of poses.
    First,
}

/// Rows of a fixed number of quantities. A quantity without a value is NaN.
#[derive(Debug)]
pub(super) struct Rows {
    kept: Kept,
    quantities: usize,
    /// Ticks per row.
    every: usize,
    /// Ticks in the last row.
    in_last: usize,
    times_s: Vec<f64>,
    /// Lowest and highest value, row by row.
    values: Vec<[f32; 2]>,
}

impl Rows {
    pub(super) fn new(kept: Kept, quantities: usize) -> Self {
        Self {
            kept,
            quantities,
            every: 1,
            in_last: 0,
            times_s: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Adds a tick.
    pub(super) fn add(&mut self, time_s: f64, values: &[f32]) {
        if self.in_last > 0 && self.in_last < self.every {
            self.in_last += 1;
            if self.kept == Kept::Extremes {
                let last = self.values.len() - self.quantities;
                for (kept, value) in self.values[last..].iter_mut().zip(values) {
                    *kept = widest(*kept, [*value; 2]);
                }
            }
            return;
        }
        self.begin_row(time_s, values.iter().copied());
        self.in_last = 1;
    }

    /// Adds a row without values, where ticks are missing.
    pub(super) fn add_gap(&mut self, time_s: f64) {
        self.begin_row(time_s, std::iter::repeat_n(f32::NAN, self.quantities));
        self.in_last = self.every;
    }

    fn begin_row(&mut self, time_s: f64, values: impl Iterator<Item = f32>) {
        while self.times_s.len() >= self.capacity() {
            self.merge();
        }
        self.times_s.push(time_s);
        self.values.extend(values.map(|value| [value; 2]));
    }

    /// Largest number of rows; those of several ticks have two values.
    fn capacity(&self) -> usize {
        if self.every == 1 || self.kept == Kept::First {
            VALUES_MAX
        } else {
            VALUES_MAX / 2
        }
    }

    /// Merges rows by two.
    fn merge(&mut self) {
        let (rows, width) = (self.times_s.len(), self.quantities);
        for row in 0..rows.div_ceil(2) {
            let (first, second) = (2 * row * width, (2 * row + 1) * width);
            self.times_s[row] = self.times_s[2 * row];
            for quantity in 0..width {
                let mut kept = self.values[first + quantity];
                if self.kept == Kept::Extremes && 2 * row + 1 < rows {
                    kept = widest(kept, self.values[second + quantity]);
                }
                self.values[row * width + quantity] = kept;
            }
        }
        self.times_s.truncate(rows.div_ceil(2));
        self.values.truncate(rows.div_ceil(2) * width);
        self.every *= 2;
    }

    /// Ticks per row.
    pub(super) fn every(&self) -> usize {
        self.every
    }

    /// Time of the first tick of each row, in s.
    pub(super) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Lowest and highest value of a quantity in each row.
    pub(super) fn values(&self, quantity: usize) -> impl Iterator<Item = [f32; 2]> + Clone {
        let values = self.values.iter().skip(quantity);
        values.step_by(self.quantities).copied()
    }
}

/// Range of two ranges; NaN is no value.
fn widest(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "values are passed through, not computed")]
mod tests {
    use super::*;

    #[test]
    fn an_hour_keeps_its_peaks_in_little_memory() {
        let mut rows = Rows::new(Kept::Extremes, 2);
        let mut poses = Rows::new(Kept::First, 2);
        for tick in 0..3_600_000_u32 {
            let value = match tick {
                1_234_567 => 9.0,
                2_345_678 => -7.0,
                _ => (f64::from(tick) * 0.01).sin() as f32,
            };
            let values = [value, f32::NAN];
            rows.add(f64::from(tick) * 1e-3, &values);
            poses.add(f64::from(tick) * 1e-3, &values);
        }
        assert!(rows.times_s().len() <= VALUES_MAX / 2 && rows.every() == 512);
        assert!(poses.times_s().len() <= VALUES_MAX && poses.every() == 256);
        let at = |row: usize| rows.values(0).nth(row).unwrap();
        assert_eq!(at(1_234_567 / 512)[1], 9.0);
        assert_eq!(at(2_345_678 / 512)[0], -7.0);
        assert_eq!(rows.times_s()[10], 5.120);
        assert!(
            rows.values(1)
                .all(|[low, high]| low.is_nan() && high.is_nan())
        );
        let pose = poses.values(0).nth(1_000).unwrap();
        assert_eq!(pose, [(256_000.0_f64 * 0.01).sin() as f32; 2]);
    }

    #[test]
    fn a_short_run_keeps_every_tick_and_its_gap() {
        let mut rows = Rows::new(Kept::Extremes, 1);
        for tick in 0..10_u8 {
            rows.add(f64::from(tick), &[f32::from(tick)]);
            if tick == 4 {
                rows.add_gap(4.5);
            }
        }
        let values: Vec<_> = rows.values(0).map(|[low, _]| low).collect();
        assert_eq!(values[..5], [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(values[5].is_nan() && values[6] == 5.0);
        assert_eq!(rows.times_s()[4..7], [4.0, 4.5, 5.0]);
    }
}
