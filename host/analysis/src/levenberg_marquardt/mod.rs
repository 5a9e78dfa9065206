//! Nonlinear least squares by Levenberg-Marquardt, with a trust region as in MINPACK.
//!
//! Moré, "The Levenberg-Marquardt algorithm: implementation and theory", 1978. Each step
//! minimises the residuals' linear model within a ball about the current coordinates, in
//! which each coordinate is scaled by the largest norm that its column of the Jacobian has
//! had. The ball grows where the model forecasts the residuals, and shrinks where it does
//! not. Its step is found in the singular vectors of the scaled Jacobian, in which the
//! damping for any radius is the root of a scalar function; the decomposition is done
//! once for each Jacobian.

mod linear_model;
#[cfg(test)]
mod tests;
mod trust_region;

use nalgebra::{DMatrix, DVector};

use linear_model::LinearModel;
use trust_region::TrustRegion;

/// A problem at its current coordinates.
pub trait LeastSquares {
    /// The coordinates.
    fn coordinates(&self) -> DVector<f64>;
    /// Changes the coordinates.
    fn set_coordinates(&mut self, coordinates: &DVector<f64>);
    /// The residuals, if they can be computed; always of one length, at least as many as
    /// there are coordinates.
    fn residuals(&self) -> Option<DVector<f64>>;
    /// Derivatives of the residuals, one row per residual, if they can be computed.
    fn jacobian(&self) -> Option<DMatrix<f64>>;
}

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Relative change of the sum of squares, and of the coordinates.
    pub tolerance: f64,
    /// Cosine between the residuals and a column of the Jacobian.
    pub gradient_tolerance: f64,
    /// Evaluations per coordinate, and as many once more.
    pub patience: usize,
}

impl Default for Limits {
    /// As near to the minimum as rounding allows.
    fn default() -> Self {
        Self {
            tolerance: 30.0 * f64::EPSILON,
            gradient_tolerance: 30.0 * f64::EPSILON,
            patience: 100,
        }
    }
}

/// End of a search. The problem has the best coordinates that were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At a minimum, within the tolerances or as far as rounding allows.
    Converged,
    /// The limit of evaluations is reached.
    OutOfPatience,
    /// Residuals or derivatives could not be computed, or are not finite.
    NotFinite,
}

/// Searches for a minimum from the problem's coordinates.
pub fn minimise(problem: &mut impl LeastSquares, limits: Limits) -> End {
    let mut x = problem.coordinates();
    let mut scale = DVector::zeros(x.len());
    let mut region = None;
    let mut evaluations_left = limits.patience * (x.len() + 1);
    let Some(mut residuals) = problem.residuals() else {
        return End::NotFinite;
    };
    loop {
        let norm = residuals.norm();
        if norm <= f64::MIN_POSITIVE {
            return End::Converged;
        }
        let is_finite = |jacobian: &DMatrix<f64>| {
            norm.is_finite() && jacobian.iter().all(|slope| slope.is_finite())
        };
        let Some(jacobian) = problem.jacobian().filter(is_finite) else {
            return End::NotFinite;
        };
        if steepest(&jacobian, &residuals) <= limits.gradient_tolerance {
            return End::Converged;
        }
        rescale(&mut scale, &jacobian);
        let region = region.get_or_insert_with(|| TrustRegion::new(x.component_mul(&scale).norm()));
        let model = LinearModel::new(jacobian, &residuals, &scale);
        // Steps from here, until one is better or the search ends.
        loop {
            let step = model.step(region);
            if !step.len.is_finite() {
                problem.set_coordinates(&x);
                return End::NotFinite;
            }
            let next = &x - &step.coordinates;
            problem.set_coordinates(&next);
            evaluations_left = evaluations_left.saturating_sub(1);
            let Some(candidate) = problem.residuals() else {
                problem.set_coordinates(&x);
                return End::NotFinite;
            };
            let forecast = step.forecast / norm.powi(2);
            let reduction = reduction(norm, candidate.norm());
            let ratio = if forecast == 0.0 {
                0.0
            } else {
                reduction / forecast
            };
            region.adapt(&step, norm, reduction, ratio);
            let is_better = ratio >= 1e-4;
            if is_better {
                x = next;
                residuals = candidate;
            }
            let is_still = reduction.abs() <= limits.tolerance && forecast <= limits.tolerance;
            let size = x.component_mul(&scale).norm();
            let end = if (is_still && ratio <= 2.0) || region.radius <= limits.tolerance * size {
                Some(End::Converged)
            } else {
                (evaluations_left <= 1).then_some(End::OutOfPatience)
            };
            if let Some(end) = end {
                if !is_better {
                    problem.set_coordinates(&x);
                }
                return end;
            }
            if is_better {
                break;
            }
        }
    }
}

/// Largest cosine between the residuals and a column of the Jacobian: zero at a minimum.
fn steepest(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> f64 {
    let cosine = |column: nalgebra::DVectorView<'_, f64>| {
        let norms = column.norm() * residuals.norm();
        if norms > 0.0 {
            column.dot(residuals).abs() / norms
        } else {
            0.0
        }
    };
    jacobian.column_iter().map(cosine).fold(0.0, f64::max)
}

/// Raises each coordinate's scale to the norm of its column; 1 where nothing depends on it.
fn rescale(scale: &mut DVector<f64>, jacobian: &DMatrix<f64>) {
    for (scale, column) in scale.iter_mut().zip(jacobian.column_iter()) {
        let norm = column.norm();
        *scale = if *scale == 0.0 && norm == 0.0 {
            1.0
        } else {
            scale.max(norm)
        };
    }
}

/// Relative fall of the sum of squares; none is worse than residuals that are not finite.
fn reduction(norm: f64, candidate: f64) -> f64 {
    if candidate.is_finite() {
        1.0 - (candidate / norm).powi(2)
    } else {
        f64::NEG_INFINITY
    }
}
