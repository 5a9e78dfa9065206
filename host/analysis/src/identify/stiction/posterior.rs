//! How likely each static friction is, by one event or by several.

/// Width of a cell, in N m: a fifth of a PWM count.
const STEP_NM: f64 = 2.5e-4;
/// Cells: up to 0.5 N m, eight times what an AX-12A has.
const CELLS: usize = 2_000;
/// What a single event leaves open in any case, in N m: a PWM count.
const LEAST_NM: f64 = 1e-3;
/// How likely it is, beside the most likely torque, that an event had another cause.
const STRANGE: f64 = 1e-3;
/// Median of the square of a standard normal number.
const MEDIAN: f64 = 0.455;

/// Likelihood of each static friction, cell by cell; any multiple.
#[derive(Clone, Debug)]
pub(super) struct Belief {
    cells: Vec<f64>,
}

impl Belief {
    /// Of an event: intervals in N m, each with its likelihood.
    pub(super) fn of(intervals: impl Iterator<Item = ([f64; 2], f64)>) -> Self {
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
            cells: smeared(&sharp),
        }
    }

    /// Mean in N m, and variance.
    pub(super) fn moments(&self) -> [f64; 2] {
        let torque_nm = |cell: usize| (cell as f64 + 0.5) * STEP_NM;
        let total: f64 = self.cells.iter().sum();
        let shares = || self.cells.iter().map(|cell| cell / total).enumerate();
        let mean: f64 = shares().map(|(cell, share)| share * torque_nm(cell)).sum();
        let square = shares().map(|(cell, share)| share * (torque_nm(cell) - mean).powi(2));
        [mean, square.sum()]
    }

    /// Mean in N m and variance by all of them. Where they differ by more than each
    /// allows, the variance is as much larger.
    pub(super) fn all(beliefs: &[Self]) -> [f64; 2] {
        let mut log = vec![0.0_f64; CELLS];
        for belief in beliefs {
            let most = belief.cells.iter().copied().fold(0.0, f64::max);
            for (log, cell) in log.iter_mut().zip(&belief.cells) {
                *log += (cell / most + STRANGE).ln();
            }
        }
        let most = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let together = Self {
            cells: log.iter().map(|log| (log - most).exp()).collect(),
        };
        let [mean, variance] = together.moments();
        let squares = beliefs.iter().map(|belief| {
            let [own, variance] = belief.moments();
            (own - mean).powi(2) / variance
        });
        let mut squares: Vec<f64> = squares.collect();
        squares.sort_by(f64::total_cmp);
        let median = squares.get(squares.len() / 2).map_or(0.0, |median| *median);
        [mean, variance * (median / MEDIAN).max(1.0)]
    }
}

/// The same if each torque may be off by [`LEAST_NM`].
fn smeared(sharp: &[f64]) -> Vec<f64> {
    const REACH: usize = (3.0 * LEAST_NM / STEP_NM) as usize;

    let weight = |far: usize| (-0.5 * (far as f64 * STEP_NM / LEAST_NM).powi(2)).exp();
    let weights: Vec<f64> = (0..=REACH).map(weight).collect();
    let mut smeared = vec![0.0; sharp.len()];
    for (cell, value) in sharp.iter().enumerate().filter(|(_, value)| **value > 0.0) {
        let reached = cell.saturating_sub(REACH)..(cell + REACH + 1).min(sharp.len());
        for other in reached {
            smeared[other] += value * weights[other.abs_diff(cell)];
        }
    }
    smeared
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 0.05 to 0.06 N m, and in the middle of it.
    fn vague() -> Belief {
        Belief::of([([0.05, 0.06], 1.0)].into_iter())
    }

    fn sharp(torque_nm: f64) -> Belief {
        Belief::of([([torque_nm; 2], 1.0)].into_iter())
    }

    #[test]
    fn an_interval_is_known_to_its_twelfth() {
        let [mean, variance] = vague().moments();
        assert!((mean - 0.055).abs() < 2e-4, "{mean}");
        let expected = (0.01_f64.powi(2) / 12.0 + LEAST_NM.powi(2)).sqrt();
        assert!(
            (variance.sqrt() / expected - 1.0).abs() < 0.05,
            "{variance:e}"
        );
    }

    #[test]
    fn a_stranger_among_them_does_not_draw_the_others() {
        let beliefs = [0.0580, 0.0585, 0.0590, 0.0300].map(sharp);
        let [mean, variance] = Belief::all(&beliefs);
        assert!((mean - 0.0585).abs() < 3e-4, "{mean}");
        assert!(variance.sqrt() < 2e-3);
    }

    #[test]
    fn what_differs_by_more_than_each_allows_is_known_less_well() {
        let close = Belief::all(&[0.0580, 0.0585, 0.0590].map(sharp));
        let apart = Belief::all(&[0.0545, 0.0585, 0.0625].map(sharp));
        assert!(apart[1] > 4.0 * close[1], "{close:?} {apart:?}");
    }
}
