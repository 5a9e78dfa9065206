//! Ball about the coordinates in which the linear model is trusted, and the step in it.

use nalgebra::DVector;

/// Ball in which the linear model is trusted.
#[derive(Debug)]
pub(super) struct TrustRegion {
    /// In scaled coordinates.
    pub(super) radius: f64,
    /// Damping of the last step.
    pub(super) damping: f64,
    /// No step is taken yet.
    pub(super) is_new: bool,
}

impl TrustRegion {
    /// A large region about coordinates of this scaled norm: the first step sets its size.
    pub(super) fn new(norm: f64) -> Self {
        const LARGE: f64 = 100.0;
        Self {
            radius: if norm == 0.0 { LARGE } else { LARGE * norm },
            damping: 0.0,
            is_new: true,
        }
    }

    /// Shrinks or grows the region by the success of a step. `norm` is that of the
    /// residuals before it, `ratio` the share of the forecast reduction that came.
    pub(super) fn adapt(&mut self, step: &Step, norm: f64, reduction: f64, ratio: f64) {
        if self.is_new {
            self.radius = self.radius.min(step.len);
            self.is_new = false;
        }
        if ratio <= 0.25 {
            let slope = -step.slope / norm.powi(2);
            let shrink = if reduction >= 0.0 {
                0.5
            } else {
                // Minimum of the parabola through both sums of squares and the slope.
                (0.5 * slope / (slope + 0.5 * reduction)).max(0.1)
            };
            self.radius = shrink * self.radius.min(10.0 * step.len);
            self.damping /= shrink;
        } else if self.damping == 0.0 || ratio >= 0.75 {
            self.radius = 2.0 * step.len;
            self.damping *= 0.5;
        }
    }
}

/// A step within a region.
pub(super) struct Step {
    /// Offset that is subtracted from the coordinates.
    pub(super) coordinates: DVector<f64>,
    /// Its length in scaled coordinates.
    pub(super) len: f64,
    /// Fall of the sum of squares by the linear model.
    pub(super) forecast: f64,
    /// Half the slope of the sum of squares along the step, downwards.
    pub(super) slope: f64,
}
