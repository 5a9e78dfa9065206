//! Linear model of the residuals, and its damped step.

use nalgebra::{DMatrix, DVector};

use super::trust_region::{Step, TrustRegion};

/// The residuals' linear model, in the singular vectors of the scaled Jacobian.
pub(super) struct LinearModel<'a> {
    scale: &'a DVector<f64>,
    values: DVector<f64>,
    /// Residuals along the left vectors.
    residuals: DVector<f64>,
    /// Right vectors, a row each.
    right: DMatrix<f64>,
}

impl<'a> LinearModel<'a> {
    pub(super) fn new(
        mut jacobian: DMatrix<f64>,
        residuals: &DVector<f64>,
        scale: &'a DVector<f64>,
    ) -> Self {
        for (mut column, scale) in jacobian.column_iter_mut().zip(scale) {
            column /= *scale;
        }
        let columns = jacobian.ncols();
        let svd = jacobian.svd(true, true);
        let residuals = svd
            .u
            .map_or_else(|| DVector::zeros(columns), |u| u.tr_mul(residuals));
        Self {
            scale,
            values: svd.singular_values,
            residuals,
            right: svd
                .v_t
                .unwrap_or_else(|| DMatrix::identity(columns, columns)),
        }
    }

    /// The scaled step with this damping, in the right vectors. Undamped, directions that
    /// change no residual are left out.
    fn damped(&self, damping: f64) -> DVector<f64> {
        let least = self.values.max() * self.values.len() as f64 * f64::EPSILON;
        self.values.zip_map(&self.residuals, |value, residual| {
            if damping == 0.0 && value <= least {
                return 0.0;
            }
            value * residual / (value * value + damping)
        })
    }

    /// The best step in the region, within a tenth of its radius; changes the damping.
    pub(super) fn step(&self, region: &mut TrustRegion) -> Step {
        let (damping, along) = self.in_region(region.radius, region.damping);
        region.damping = damping;
        let len = along.norm();
        let fall = self.values.component_mul(&along).norm_squared();
        let damped = damping * len * len;
        Step {
            coordinates: self.right.tr_mul(&along).component_div(self.scale),
            len,
            forecast: fall + 2.0 * damped,
            slope: fall + damped,
        }
    }

    /// Damping and step for a radius; the search for the damping begins at `guess`.
    fn in_region(&self, radius: f64, guess: f64) -> (f64, DVector<f64>) {
        /// Largest relative excess of the step over the radius.
        const EXCESS: f64 = 0.1;
        /// Newton's method needs two or three.
        const ITERATIONS: usize = 10;

        let undamped = self.damped(0.0);
        let excess = undamped.norm() - radius;
        if excess <= EXCESS * radius {
            return (0.0, undamped);
        }
        // Newton's correction of the damping, by which a step's length falls to the radius.
        let correction = |along: &DVector<f64>, damping: f64| {
            let len = along.norm();
            let parts = along.zip_map(&self.values, |along, value| {
                (along / len).powi(2) / (value * value + damping)
            });
            (len - radius) / (radius * parts.sum())
        };
        let is_full_rank = self.values.min() > 0.0 && undamped.iter().all(|along| *along != 0.0);
        let mut least = if is_full_rank {
            correction(&undamped, 0.0)
        } else {
            0.0
        };
        let gradient = self.values.component_mul(&self.residuals).norm();
        let mut most = gradient / radius;
        let mut damping = guess.max(least).min(most);
        if damping == 0.0 {
            damping = gradient / undamped.norm();
        }
        for _ in 0..ITERATIONS {
            if damping == 0.0 {
                damping = (1e-3 * most).max(f64::MIN_POSITIVE);
            }
            let along = self.damped(damping);
            let excess = along.norm() - radius;
            if excess.abs() <= EXCESS * radius {
                return (damping, along);
            }
            if excess > 0.0 {
                least = least.max(damping);
            } else {
                most = most.min(damping);
            }
            damping = least.max(damping + correction(&along, damping)).min(most);
        }
        (damping, self.damped(damping))
    }
}
