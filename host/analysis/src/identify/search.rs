//! The search for the numbers that explain what was measured.
//!
//! Levenberg-Marquardt on the errors of the windows' motions, with what is believed
//! beforehand as errors of their own: a number that the logs say nothing about stays
//! where it was, and its uncertainty with it.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{SMatrix, SVector};
use nalgebra_lm as lm;

use super::arm::Known;
use super::cost::{Cost, Stretch, cost};
use super::dataset::Trace;
use super::quantity::{COUNT, Quantity};

/// Rows of the problem: as many as there are numbers for all windows together, one for
/// what no number can explain, and one for each belief.
const ROWS: usize = 2 * COUNT + 1;

/// What is believed of each number beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Its coordinate.
    pub mean: [f64; COUNT],
    /// How far off that may be, one standard deviation.
    pub deviation: [f64; COUNT],
}

/// A search under way.
pub(super) struct Search<'a> {
    stretches: Vec<Stretch>,
    traces: &'a [Trace],
    known: &'a Known,
    prior: Prior,
    /// Variance of an error in counts squared.
    variance: f64,
    /// Mean square of a window's errors beyond which it counts less.
    most: f64,
    at: [f64; COUNT],
    cost: Cost,
}

impl<'a> Search<'a> {
    /// Begins at these coordinates.
    pub(super) fn begin(
        mut stretches: Vec<Stretch>,
        traces: &'a [Trace],
        known: &'a Known,
        prior: &Prior,
        at: [f64; COUNT],
        [variance, most]: [f64; 2],
    ) -> Self {
        let cost = cost(&mut stretches, traces, known, &at, most);
        // Where there is no dead zone, nothing holds an edge against what is believed of it,
        // until it is in the middle of what the logs say: there the search would end.
        let mut prior = *prior;
        Quantity::edges().for_each(|edge| prior.mean[edge] = at[edge]);
        Self {
            stretches,
            traces,
            known,
            prior,
            variance,
            most,
            at,
            cost,
        }
    }

    /// Goes down as far as it goes.
    #[must_use]
    pub(super) fn run(self) -> Self {
        /// Evaluations for each number, beyond which nothing is gained any more.
        const PATIENCE: usize = 15;
        self.down(PATIENCE)
    }

    /// The same for one of many tries: who begins far off, where no slope leads anywhere, is
    /// given up soon.
    #[must_use]
    pub(super) fn try_once(self) -> Self {
        /// Evaluations for each number: twice as many as a try takes that comes to anything.
        const PATIENCE: usize = 2;
        self.down(PATIENCE)
    }

    fn down(self, patience: usize) -> Self {
        /// Relative change of sum and numbers below which it is at the bottom: a
        /// thousandth of what is known of them.
        const TOLERANCE: f64 = 1e-6;

        let (search, _) = LevenbergMarquardt::new()
            .with_patience(patience)
            .with_ftol(TOLERANCE)
            .with_xtol(TOLERANCE)
            .minimize(self);
        search
    }

    /// Where it is.
    pub(super) fn at(&self) -> [f64; COUNT] {
        self.at
    }

    /// The windows, as they are explained there.
    pub(super) fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// What is minimised: twice the negative logarithm of the likelihood, but for a
    /// constant.
    pub(super) fn loss(&self) -> f64 {
        let beliefs = (0..COUNT).map(|i| self.belief(i).powi(2));
        self.cost.squares / self.variance + beliefs.sum::<f64>()
    }

    /// What is known of the numbers, the inverse of their covariance.
    pub(super) fn information(&self) -> SMatrix<f64, COUNT, COUNT> {
        let beliefs = SVector::from(self.prior.deviation).map(|deviation: f64| deviation.powi(-2));
        self.cost.hessian / self.variance + SMatrix::from_diagonal(&beliefs)
    }

    /// Scatter of what the windows say about the numbers, in the same unit.
    pub(super) fn scatter(&self) -> SMatrix<f64, COUNT, COUNT> {
        self.cost.scatter / self.variance.powi(2)
    }

    fn belief(&self, i: usize) -> f64 {
        (self.at[i] - self.prior.mean[i]) / self.prior.deviation[i]
    }

    /// As many rows as there are numbers, with the slope and the curvature of all.
    fn rows(&self) -> Option<(SMatrix<f64, COUNT, COUNT>, SVector<f64, COUNT>)> {
        let mut hessian = self.cost.hessian / self.variance;
        // What the windows say nothing about is left to the beliefs.
        let least = hessian.diagonal().amax() * 1e-13 + 1e-12;
        hessian += SMatrix::from_diagonal_element(least);
        let lower = hessian.cholesky()?.l();
        // Errors are measured less computed: they fall along the gradient.
        let top = lower.solve_lower_triangular(&(self.cost.gradient / -self.variance))?;
        Some((lower.transpose(), top))
    }
}

impl LeastSquaresProblem<f64, lm::Const<ROWS>, lm::Const<COUNT>> for Search<'_> {
    type ResidualStorage = lm::storage::Owned<f64, lm::Const<ROWS>>;
    type JacobianStorage = lm::storage::Owned<f64, lm::Const<ROWS>, lm::Const<COUNT>>;
    type ParameterStorage = lm::storage::Owned<f64, lm::Const<COUNT>>;

    fn set_params(&mut self, x: &lm::SVector<f64, COUNT>) {
        let at: [f64; COUNT] = (*x).into();
        if at.map(f64::to_bits) != self.at.map(f64::to_bits) {
            self.at = at;
            self.cost = cost(&mut self.stretches, self.traces, self.known, &at, self.most);
        }
    }

    fn params(&self) -> lm::SVector<f64, COUNT> {
        self.at.into()
    }

    fn residuals(&self) -> Option<lm::SVector<f64, ROWS>> {
        let (_, top) = self.rows()?;
        let rest = self.cost.squares / self.variance - top.norm_squared();
        Some(lm::SVector::from_fn(|i, _| match i {
            i if i < COUNT => top[i],
            i if i < 2 * COUNT => self.belief(i - COUNT),
            _ => rest.max(0.0).sqrt(),
        }))
    }

    fn jacobian(&self) -> Option<lm::SMatrix<f64, ROWS, COUNT>> {
        let (upper, _) = self.rows()?;
        Some(lm::SMatrix::from_fn(|i, j| match i {
            i if i < COUNT => upper[(i, j)],
            i if i == COUNT + j => 1.0 / self.prior.deviation[j],
            _ => 0.0,
        }))
    }
}
