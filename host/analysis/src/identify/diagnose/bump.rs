//! Bump function: weighted means over a segment of ticks, with weights that vanish at its
//! ends. The mean of a derivative is one of the values, and noise falls with the length of
//! the segment.

/// Weights `(1 - x²)²` over a segment, x from -1 to 1, normalised to a sum of one.
#[derive(Clone, Debug)]
pub(in super::super) struct Bump {
    weights: Vec<f64>,
    /// Derivatives of the weights by the tick.
    slopes: Vec<f64>,
}

impl Bump {
    /// A bump of `half` ticks on either side of the middle.
    pub(in super::super) fn new(half: usize) -> Self {
        let shape = |index: usize| {
            let x = (index as f64 - half as f64) / half as f64;
            (x, 1.0 - x * x)
        };
        let ticks = || (0..=2 * half).map(shape);
        let sum: f64 = ticks().map(|(_, rest)| rest * rest).sum();
        Self {
            weights: ticks().map(|(_, rest)| rest * rest / sum).collect(),
            slopes: ticks()
                .map(|(x, rest)| -4.0 * x * rest / half as f64 / sum)
                .collect(),
        }
    }

    /// Length in ticks.
    pub(in super::super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// Weighted mean of a function of the tick, over the segment that begins at `first`.
    pub(in super::super) fn mean(&self, first: usize, value: impl Fn(usize) -> f64) -> f64 {
        let ticks = self.weights.iter().enumerate();
        ticks.map(|(k, weight)| weight * value(first + k)).sum()
    }

    /// Weighted mean of its derivative by the tick.
    pub(in super::super) fn rate(&self, first: usize, value: impl Fn(usize) -> f64) -> f64 {
        let ticks = self.slopes.iter().enumerate();
        -ticks
            .map(|(k, slope)| slope * value(first + k))
            .sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_the_mean_and_the_rate_of_its_middle() {
        let bump = Bump::new(50);
        assert_eq!(bump.len(), 101);
        let line = |tick: usize| 3.0 + 0.5 * tick as f64;
        assert!((bump.mean(20, line) - line(70)).abs() < 1e-9);
        let parabola = |tick: usize| 0.01 * (tick as f64).powi(2);
        // Derivatives of the weights in place of their differences: right to a thousandth.
        assert!((bump.rate(20, parabola) / (0.02 * 70.0) - 1.0).abs() < 1e-3);
    }
}
