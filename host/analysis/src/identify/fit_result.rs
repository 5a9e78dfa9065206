//! Result of a fit: the parameters, their covariance, and the windows that they explain.

use armbridge_servo::JOINTS;
use nalgebra::SMatrix;

use super::arm::KnownParameters;
use super::cost::WindowFit;
use super::dataset::Trace;
use super::load::LoadEstimate;
use super::prior::Prior;
use super::quantity::{COUNT, Quantity};
use super::stiction::StaticFriction;
use super::stribeck::StribeckEstimate;

/// A fitted arm.
#[derive(Clone, Debug)]
pub struct FitResult {
    /// Coordinates of the parameters.
    pub coordinates: [f64; COUNT],
    /// Covariance of the coordinates.
    pub covariance: SMatrix<f64, COUNT, COUNT>,
    /// Standard deviation of each coordinate without the prior of the weight.
    pub deviation_without_weight: [f64; COUNT],
    /// Standard deviation of an encoder's noise in counts, rounding included.
    pub noise_counts: f64,
    /// Stribeck curve of each joint, where the logs show one.
    pub stribeck: [Option<StribeckEstimate>; JOINTS],
    /// Load friction of each joint, where the logs show it.
    pub load: [Option<LoadEstimate>; JOINTS],
    /// Static friction of each joint, where there are breakaways enough.
    pub static_friction: [Option<StaticFriction>; JOINTS],
    /// The windows, with their residuals.
    pub window_fits: Vec<WindowFit>,
    /// Mean square of a window's residuals above which it is an outlier, in counts squared.
    pub outlier_limit_counts2: f64,
}

impl FitResult {
    /// Estimate of a parameter, and its standard error.
    pub fn estimate(&self, joint: usize, quantity: Quantity) -> (f64, f64) {
        let i = quantity.index(joint);
        let deviation = self.covariance[(i, i)].max(0.0).sqrt();
        let value: f64 = quantity.value(self.coordinates[i]);
        // An edge on the wrong side of neutral is that of no dead zone.
        let value = if self.has_no_dead_zone(i) { 0.0 } else { value };
        (
            value,
            deviation * quantity.derivative(self.coordinates[i]).abs(),
        )
    }

    /// Whether this coordinate is the edge of a dead zone that does not exist.
    pub(super) fn has_no_dead_zone(&self, index: usize) -> bool {
        Quantity::dead_zone_edges().any(|edge| edge == index) && self.coordinates[index] <= 0.0
    }

    /// Whether the arm's weight alone fixes a parameter's scale: its standard deviation is
    /// below a tenth with the weight, and above without.
    pub fn is_fixed_by_weight(&self, joint: usize, quantity: Quantity) -> bool {
        let i = quantity.index(joint);
        quantity.is_relative()
            && self.deviation_without_weight[i] > 0.1
            && self.covariance[(i, i)].sqrt() < 0.1
    }

    /// Whether a parameter is unidentified: its standard deviation is above half of the
    /// prior's.
    pub fn is_unidentified(&self, prior: &Prior, joint: usize, quantity: Quantity) -> bool {
        let i = quantity.index(joint);
        quantity != Quantity::Gravity && self.covariance[(i, i)].sqrt() > 0.5 * prior.deviation[i]
    }

    /// Number of windows that are outliers.
    pub fn outliers(&self) -> usize {
        let limit = self.outlier_limit_counts2;
        let is_outlier = |window_fit: &&WindowFit| !window_fit.is_explained(limit);
        self.window_fits.iter().filter(is_outlier).count()
    }

    /// Ticks in all windows.
    pub(super) fn window_ticks(&self) -> usize {
        let lengths = self.window_fits.iter().map(|fit| fit.window.len);
        lengths.sum()
    }

    /// The traces, smoothed with the estimated encoder zeros.
    pub(super) fn smoothed(&self, traces: &[Trace], known: &KnownParameters) -> Vec<Trace> {
        let zero = [0, 1].map(|joint| self.estimate(joint, Quantity::Zero).0);
        let smooth = |trace: &Trace| trace.smoothed(known, zero);
        traces.iter().map(smooth).collect()
    }
}
