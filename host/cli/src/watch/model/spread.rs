//! How a quantity is spread: mean, largest, and a histogram of so many bins.

/// Of some values.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub most: f64,
    /// Values in each bin, from [`Spread::least`] to [`Spread::most`].
    pub bins: Vec<u32>,
}

impl Spread {
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
        let mut spread = Self {
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
            spread.bins[bin.min(bins - 1)] += 1;
        }
        Some(spread)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_a_bin() {
        let values = [1.0, 2.0, 2.1, 5.0];
        let spread = Spread::of(values.into_iter(), 4).unwrap();
        assert_eq!(spread.bins, [1, 2, 0, 1]);
        assert!((spread.mean - 2.525).abs() < 1e-12);
        assert_eq!(Spread::of(std::iter::empty(), 4), None);
        let same = Spread::of([3.0; 5].into_iter(), 3).unwrap();
        assert_eq!(same.bins, [5, 0, 0]);
    }
}
