//! Likelihood of each static friction, from one breakaway or several.

/// Width of a cell in N m: a fifth of a PWM count.
const STEP_NM: f64 = 2.5e-4;
/// Number of cells: up to 0.5 N m, eight times the static friction of an AX-12A.
const CELLS: usize = 2_000;
/// Resolution of a single breakaway in N m: a PWM count.
const RESOLUTION_NM: f64 = 1e-3;
/// Likelihood that a breakaway had another cause, relative to that of the most likely
/// torque.
const OUTLIER_LIKELIHOOD: f64 = 1e-3;
/// Median of the square of a standard normal variable.
const CHI_SQUARED_MEDIAN: f64 = 0.455;

/// Likelihood of each static friction, cell by cell, up to a factor.
#[derive(Clone, Debug)]
pub(super) struct TorqueLikelihood {
    cells: Vec<f64>,
}

impl TorqueLikelihood {
    /// Likelihood from a breakaway: intervals in N m, each with its likelihood.
    pub(super) fn from_intervals(intervals: impl Iterator<Item = ([f64; 2], f64)>) -> Self {
        let mut sharp = vec![0.0; CELLS];
        for (torques_nm, likelihood) in intervals {
            let [low, high] = torques_nm.map(|torque_nm| {
                let cell = (torque_nm / STEP_NM).max(0.0) as usize;
                cell.min(CELLS - 1)
            });
            for cell in &mut sharp[low..=high] {
                *cell = likelihood.max(*cell);
            }
        }
        Self {
            cells: smoothed(&sharp),
        }
    }

    /// Mean in N m, and variance in N² m².
    pub(super) fn moments(&self) -> [f64; 2] {
        let torque_nm = |cell: usize| (cell as f64 + 0.5) * STEP_NM;
        let total: f64 = self.cells.iter().sum();
        let weights = || self.cells.iter().map(|cell| cell / total).enumerate();
        let mean: f64 = weights()
            .map(|(cell, weight)| weight * torque_nm(cell))
            .sum();
        let square = weights().map(|(cell, weight)| weight * (torque_nm(cell) - mean).powi(2));
        [mean, square.sum()]
    }

    /// Mean and variance of the product of these likelihoods. The variance is increased where
    /// they differ by more than each allows.
    pub(super) fn combined_moments(likelihoods: &[Self]) -> [f64; 2] {
        let mut log = vec![0.0_f64; CELLS];
        for likelihood in likelihoods {
            let maximum = likelihood.cells.iter().copied().fold(0.0, f64::max);
            for (log, cell) in log.iter_mut().zip(&likelihood.cells) {
                *log += (cell / maximum + OUTLIER_LIKELIHOOD).ln();
            }
        }
        let maximum = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let product = Self {
            cells: log.iter().map(|log| (log - maximum).exp()).collect(),
        };
        let [mean, variance] = product.moments();
        let squares = likelihoods.iter().map(|likelihood| {
            let [own, variance] = likelihood.moments();
            (own - mean).powi(2) / variance
        });
        let mut squares: Vec<f64> = squares.collect();
        squares.sort_by(f64::total_cmp);
        let median = squares.get(squares.len() / 2).map_or(0.0, |median| *median);
        [mean, variance * (median / CHI_SQUARED_MEDIAN).max(1.0)]
    }
}

/// Convolution with a normal distribution of standard deviation [`RESOLUTION_NM`].
fn smoothed(sharp: &[f64]) -> Vec<f64> {
    const REACH: usize = (3.0 * RESOLUTION_NM / STEP_NM) as usize;

    let weight =
        |distance: usize| (-0.5 * (distance as f64 * STEP_NM / RESOLUTION_NM).powi(2)).exp();
    let weights: Vec<f64> = (0..=REACH).map(weight).collect();
    let mut smoothed = vec![0.0; sharp.len()];
    for (cell, value) in sharp.iter().enumerate().filter(|(_, value)| **value > 0.0) {
        let reached = cell.saturating_sub(REACH)..(cell + REACH + 1).min(sharp.len());
        for other in reached {
            smoothed[other] += value * weights[other.abs_diff(cell)];
        }
    }
    smoothed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A uniform likelihood from 0.05 to 0.06 N m.
    fn wide() -> TorqueLikelihood {
        TorqueLikelihood::from_intervals([([0.05, 0.06], 1.0)].into_iter())
    }

    fn sharp(torque_nm: f64) -> TorqueLikelihood {
        TorqueLikelihood::from_intervals([([torque_nm; 2], 1.0)].into_iter())
    }

    #[test]
    fn the_variance_of_an_interval_is_a_twelfth_of_its_square() {
        let [mean, variance] = wide().moments();
        assert!((mean - 0.055).abs() < 2e-4, "{mean}");
        let expected = (0.01_f64.powi(2) / 12.0 + RESOLUTION_NM.powi(2)).sqrt();
        assert!(
            (variance.sqrt() / expected - 1.0).abs() < 0.05,
            "{variance:e}"
        );
    }

    #[test]
    fn an_outlier_does_not_shift_the_mean() {
        let likelihoods = [0.0580, 0.0585, 0.0590, 0.0300].map(sharp);
        let [mean, variance] = TorqueLikelihood::combined_moments(&likelihoods);
        assert!((mean - 0.0585).abs() < 3e-4, "{mean}");
        assert!(variance.sqrt() < 2e-3);
    }

    #[test]
    fn inconsistent_breakaways_increase_the_variance() {
        let close = TorqueLikelihood::combined_moments(&[0.0580, 0.0585, 0.0590].map(sharp));
        let apart = TorqueLikelihood::combined_moments(&[0.0545, 0.0585, 0.0625].map(sharp));
        assert!(apart[1] > 4.0 * close[1], "{close:?} {apart:?}");
    }
}
