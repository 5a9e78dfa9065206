//! Minimisation of the cost: Levenberg-Marquardt on the windows' residuals.
//!
//! The prior enters as residuals of its own: a parameter without information in the logs
//! stays at its prior mean, with its prior uncertainty.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::arm::KnownParameters;
use super::cost::{Cost, WindowFit, cost};
use super::dataset::Trace;
use super::prior::Prior;
use super::quantity::{COUNT, Quantity};
use crate::levenberg_marquardt::{LeastSquares, Limits, minimise};

/// Rows of the problem: one per parameter for all windows together, one for the residual
/// that no parameter reduces, and one per parameter for the prior.
const ROWS: usize = 2 * COUNT + 1;

/// Scale of the residuals.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorModel {
    /// Variance of a residual in counts squared.
    pub(super) variance_counts2: f64,
    /// Mean square of a window's residuals above which its weight falls, in counts squared.
    pub(super) outlier_limit_counts2: f64,
}

/// A minimisation under way.
pub(super) struct Search<'a> {
    window_fits: Vec<WindowFit>,
    traces: &'a [Trace],
    known: &'a KnownParameters,
    prior: Prior,
    errors: ErrorModel,
    coordinates: [f64; COUNT],
    cost: Cost,
}

impl<'a> Search<'a> {
    /// A search that begins at these coordinates.
    pub(super) fn new(
        mut window_fits: Vec<WindowFit>,
        traces: &'a [Trace],
        known: &'a KnownParameters,
        prior: &Prior,
        coordinates: [f64; COUNT],
        errors: ErrorModel,
    ) -> Self {
        let limit = errors.outlier_limit_counts2;
        let cost = cost(&mut window_fits, traces, known, &coordinates, limit);
        // Without a dead zone nothing holds an edge against its prior until the edge is in
        // the midst of the logs' PWM, where the search would end: the prior of an edge is
        // centred at its initial guess.
        let mut prior = *prior;
        Quantity::dead_zone_edges().for_each(|edge| prior.mean[edge] = coordinates[edge]);
        Self {
            window_fits,
            traces,
            known,
            prior,
            errors,
            coordinates,
            cost,
        }
    }

    /// Minimises until it converges.
    #[must_use]
    pub(super) fn minimise(self) -> Self {
        /// Evaluations per parameter, beyond which no improvement is expected.
        const PATIENCE: usize = 15;
        self.levenberg_marquardt(PATIENCE)
    }

    /// Minimises from one of several initial guesses: one far off, where no gradient leads
    /// to a minimum, is given up soon.
    #[must_use]
    pub(super) fn minimise_briefly(self) -> Self {
        /// Evaluations per parameter: twice as many as a successful guess takes.
        const PATIENCE: usize = 2;
        self.levenberg_marquardt(PATIENCE)
    }

    fn levenberg_marquardt(mut self, patience: usize) -> Self {
        /// Relative change of cost and coordinates at convergence. The cost is about the
        /// number of residuals, at most some 10⁴: it then changes by 10⁻⁵ or less, and a
        /// coordinate by 0.003 of its uncertainty.
        const TOLERANCE: f64 = 1e-9;

        let limits = Limits {
            tolerance: TOLERANCE,
            patience,
            ..Limits::default()
        };
        // However it ends, the best coordinates are kept.
        minimise(&mut self, limits);
        self
    }

    /// The current coordinates.
    pub(super) fn coordinates(&self) -> [f64; COUNT] {
        self.coordinates
    }

    /// The windows, with their residuals at the current coordinates.
    pub(super) fn window_fits(&self) -> &[WindowFit] {
        &self.window_fits
    }

    /// Loss: twice the negative logarithm of the posterior, up to a constant.
    pub(super) fn loss(&self) -> f64 {
        let prior_terms = (0..COUNT).map(|i| self.prior_residual(i).powi(2));
        self.cost.squares / self.errors.variance_counts2 + prior_terms.sum::<f64>()
    }

    /// Part of each window in it.
    pub(super) fn window_losses(&self) -> Vec<f64> {
        let ErrorModel {
            variance_counts2,
            outlier_limit_counts2,
        } = self.errors;
        let windows = self.window_fits.iter();
        windows
            .map(|fit| fit.weighted_squares(outlier_limit_counts2).0 / variance_counts2)
            .collect()
    }

    /// Information matrix of logs and prior, the inverse of the covariance.
    pub(super) fn information(&self) -> SMatrix<f64, COUNT, COUNT> {
        let prior = SVector::from(self.prior.deviation).map(|deviation: f64| deviation.powi(-2));
        self.cost.hessian / self.errors.variance_counts2 + SMatrix::from_diagonal(&prior)
    }

    /// Scatter of the windows' gradients, in the unit of [`information`](Self::information).
    pub(super) fn scatter(&self) -> SMatrix<f64, COUNT, COUNT> {
        self.cost.scatter / self.errors.variance_counts2.powi(2)
    }

    fn prior_residual(&self, i: usize) -> f64 {
        (self.coordinates[i] - self.prior.mean[i]) / self.prior.deviation[i]
    }

    /// Square root of the normal equations: as many rows as there are parameters, with the
    /// gradient and the Hessian of all residuals.
    fn square_root(&self) -> Option<(SMatrix<f64, COUNT, COUNT>, SVector<f64, COUNT>)> {
        let mut hessian = self.cost.hessian / self.errors.variance_counts2;
        // Parameters without information are left to the prior.
        let least = hessian.diagonal().amax() * 1e-13 + 1e-12;
        hessian += SMatrix::from_diagonal_element(least);
        let lower = hessian.cholesky()?.l();
        // Residuals are measured less computed: they fall along the gradient.
        let gradient = self.cost.gradient / -self.errors.variance_counts2;
        let top = lower.solve_lower_triangular(&gradient)?;
        Some((lower.transpose(), top))
    }
}

impl LeastSquares for Search<'_> {
    fn coordinates(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.coordinates)
    }

    fn set_coordinates(&mut self, x: &DVector<f64>) {
        let coordinates: [f64; COUNT] = core::array::from_fn(|i| x[i]);
        if coordinates.map(f64::to_bits) != self.coordinates.map(f64::to_bits) {
            self.coordinates = coordinates;
            let limit = self.errors.outlier_limit_counts2;
            let (traces, known) = (self.traces, self.known);
            self.cost = cost(&mut self.window_fits, traces, known, &coordinates, limit);
        }
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let (_, top) = self.square_root()?;
        let rest = self.cost.squares / self.errors.variance_counts2 - top.norm_squared();
        Some(DVector::from_fn(ROWS, |i, _| match i {
            i if i < COUNT => top[i],
            i if i < 2 * COUNT => self.prior_residual(i - COUNT),
            _ => rest.max(0.0).sqrt(),
        }))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let (upper, _) = self.square_root()?;
        Some(DMatrix::from_fn(ROWS, COUNT, |i, j| match i {
            i if i < COUNT => upper[(i, j)],
            i if i == COUNT + j => 1.0 / self.prior.deviation[j],
            _ => 0.0,
        }))
    }
}
