//! Histogram of a quantity, with its mean and range.

/// Histogram of some values.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Mean.
    pub mean: f64,
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub most: f64,
    /// Values in each bin, from [`Histogram::least`] to [`Histogram::most`].
    pub bins: Vec<u32>,
}

impl Histogram {
    /// `None` without values.
    pub fn of(values: impl Iterator<Item = f64> + Clone, bins: usize) -> Option<Self> {
        let (mut count, mut sum) = (0_u32, 0.0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.clone() {
            count += 1;
            sum += value;
            least = least.min(value);
            most = most.max(value);
        }
        if count == 0 || bins == 0 {
            return None;
        }
        let mut histogram = Self {
            mean: sum / f64::from(count),
            least,
            most,
            bins: vec![0; bins],
        };
        let width = (most - least) / bins as f64;
        for value in values {
            let bin = if width > 0.0 {
                ((value - least) / width) as usize
            } else {
                0
            };
            histogram.bins[bin.min(bins - 1)] += 1;
        }
        Some(histogram)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_a_bin() {
        let values = [1.0, 2.0, 2.1, 5.0];
        let histogram = Histogram::of(values.into_iter(), 4).unwrap();
        assert_eq!(histogram.bins, [1, 2, 0, 1]);
        assert!((histogram.mean - 2.525).abs() < 1e-12);
        assert_eq!(Histogram::of(std::iter::empty(), 4), None);
        let same = Histogram::of([3.0; 5].into_iter(), 3).unwrap();
        assert_eq!(same.bins, [5, 0, 0]);
    }
}
