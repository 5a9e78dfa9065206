//! Minimisation by covariance matrix adaptation (CMA-ES), without derivatives.
//!
//! Hansen, "The CMA evolution strategy: a tutorial", 2016. Each generation draws candidates from
//! a normal distribution; the better half moves its mean, widens it along its course and narrows
//! it across.
//!
//! Where a pendulum sticks or slips for a little more friction, the error of a simulation jumps:
//! Levenberg-Marquardt ends at the nearest ledge. The distribution is wider than the ledges
//! until the end.
//!
//! The result depends on function, start and seed alone.

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;

/// Stream of the generator; other generators use 0 to 9.
const STREAM: u64 = 10;

/// Extent of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Candidates in a generation; the more, the more local minima are passed over.
    pub(super) population: usize,
    /// Most evaluations.
    pub(super) evaluations: usize,
    /// Standard deviation of each coordinate at the start.
    pub(super) deviation: f64,
    /// The search ends when it is everywhere below this.
    pub(super) deviation_min: f64,
    /// Seed of the draws.
    pub(super) seed: u64,
}

/// Weights and rates, which follow from the number of coordinates.
struct Strategy {
    weights: Vec<f64>,
    effective: f64,
    path_rate: f64,
    deviation_rate: f64,
    rank_one_rate: f64,
    rank_many_rate: f64,
    damping: f64,
    expected_length: f64,
}

impl Strategy {
    fn new(coordinates: usize, population: usize) -> Self {
        let n = coordinates as f64;
        let parents = (population / 2).max(2);
        let weight = |i: usize| (parents as f64 + 0.5).ln() - ((i + 1) as f64).ln();
        let sum: f64 = (0..parents).map(weight).sum();
        let weights: Vec<f64> = (0..parents).map(|i| weight(i) / sum).collect();
        let effective = 1.0 / weights.iter().map(|weight| weight.powi(2)).sum::<f64>();
        let deviation_rate = (effective + 2.0) / (n + effective + 5.0);
        let rank_one_rate = 2.0 / ((n + 1.3).powi(2) + effective);
        let many = 2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective);
        Self {
            effective,
            path_rate: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            deviation_rate,
            rank_one_rate,
            rank_many_rate: many.min(1.0 - rank_one_rate),
            damping: 1.0
                + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0)
                + deviation_rate,
            expected_length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
            weights,
        }
    }

    fn population(&self) -> usize {
        2 * self.weights.len()
    }
}

/// The distribution of the candidates, and the paths of its mean.
struct Distributed {
    mean: DVector<f64>,
    deviation: f64,
    covariance: DMatrix<f64>,
    path: DVector<f64>,
    whitened_path: DVector<f64>,
}

impl Distributed {
    /// Axes of the covariance as columns, and their lengths.
    fn axes(&self) -> (DMatrix<f64>, DVector<f64>) {
        let decomposition = self.covariance.clone().symmetric_eigen();
        let lengths = decomposition
            .eigenvalues
            .map(|square| square.max(1e-20).sqrt());
        (decomposition.eigenvectors, lengths)
    }

    /// Moves to the steps of the best candidates, in units of the deviation.
    fn adapt(
        &mut self,
        strategy: &Strategy,
        steps: &[DVector<f64>],
        axes: &DMatrix<f64>,
        lengths: &DVector<f64>,
        generation: usize,
    ) {
        let n = self.mean.len();
        let weighted = strategy.weights.iter().zip(steps);
        let step = weighted
            .clone()
            .fold(DVector::zeros(n), |sum, (weight, step)| {
                sum + step * *weight
            });
        self.mean += &step * self.deviation;
        let rate = strategy.deviation_rate;
        let white = axes * (axes.transpose() * &step).component_div(lengths);
        self.whitened_path *= 1.0 - rate;
        self.whitened_path += white * (rate * (2.0 - rate) * strategy.effective).sqrt();
        let length = self.whitened_path.norm();
        let memory = 1.0 - (1.0 - rate).powi(2 * generation as i32);
        let limit = (1.4 + 2.0 / (n as f64 + 1.0)) * strategy.expected_length;
        let is_short = length / memory.sqrt() < limit;
        let rate = strategy.path_rate;
        self.path *= 1.0 - rate;
        if is_short {
            self.path += &step * (rate * (2.0 - rate) * strategy.effective).sqrt();
        }
        let (one, many) = (strategy.rank_one_rate, strategy.rank_many_rate);
        let kept = if is_short { 0.0 } else { rate * (2.0 - rate) };
        self.covariance *= 1.0 - one - many + one * kept;
        self.covariance += &self.path * self.path.transpose() * one;
        for (weight, step) in weighted {
            self.covariance += step * step.transpose() * (many * weight);
        }
        let excess = length / strategy.expected_length - 1.0;
        self.deviation *= (strategy.deviation_rate / strategy.damping * excess)
            .min(1.0)
            .exp();
    }
}

/// The best coordinates found from a start, and the function's value there. Values that are not
/// numbers are worse than all others.
pub(super) fn minimise(
    function: impl Fn(&DVector<f64>) -> f64,
    start: &DVector<f64>,
    search: &Search,
) -> (DVector<f64>, f64) {
    let n = start.len();
    let strategy = Strategy::new(n, search.population);
    let mut random = Pcg32::new(search.seed, STREAM);
    let mut state = Distributed {
        mean: start.clone(),
        deviation: search.deviation,
        covariance: DMatrix::identity(n, n),
        path: DVector::zeros(n),
        whitened_path: DVector::zeros(n),
    };
    let mut best = (start.clone(), function(start));
    let generations = search.evaluations / strategy.population();
    for generation in 1..=generations {
        let (axes, lengths) = state.axes();
        let mut candidates: Vec<(f64, DVector<f64>)> = (0..strategy.population())
            .map(|_| {
                let unit = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
                let unit: DVector<f64> = unit;
                let step = &axes * unit.component_mul(&lengths);
                let value = function(&(&state.mean + &step * state.deviation));
                (if value.is_nan() { f64::INFINITY } else { value }, step)
            })
            .collect();
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        if candidates[0].0 < best.1 || best.1.is_nan() {
            let coordinates = &state.mean + &candidates[0].1 * state.deviation;
            best = (coordinates, candidates[0].0);
        }
        if candidates[0].0 == f64::INFINITY {
            // No number in this generation says where to go.
            continue;
        }
        let steps: Vec<DVector<f64>> = candidates.into_iter().map(|it| it.1).collect();
        state.adapt(&strategy, &steps, &axes, &lengths, generation);
        let widest = state.deviation * state.covariance.diagonal().max().sqrt();
        if !widest.is_finite() || widest < search.deviation_min {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let valley = |x: &DVector<f64>| {
            let pairs = (1..x.len()).map(|i| (x[i - 1], x[i]));
            pairs
                .map(|(a, b)| 100.0 * (b - a * a).powi(2) + (1.0 - a).powi(2))
                .sum()
        };
        let search = Search {
            population: 12,
            evaluations: 20_000,
            deviation: 0.5,
            deviation_min: 1e-9,
            seed: 1,
        };
        let (x, value) = minimise(valley, &DVector::zeros(5), &search);
        assert!(value < 1e-10, "{value} at {x}");
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-4), "{x}");
    }

    #[test]
    fn values_that_are_not_numbers_are_avoided() {
        let half = |x: &DVector<f64>| if x[0] < 0.5 { f64::NAN } else { x.norm() };
        let search = Search {
            population: 12,
            evaluations: 2_000,
            deviation: 0.5,
            deviation_min: 1e-9,
            seed: 1,
        };
        let (x, value) = minimise(half, &DVector::zeros(2), &search);
        assert!((value - 0.5).abs() < 1e-3, "{value} at {x}");
    }
}
