//! Profile of the loss over the parameters of a form of dry friction: for each of their values the
//! joint's other parameters are fitted again, in the joint's own windows.
//!
//! Near the minimum the profile is a quadratic form: a few Newton steps find it, and its curvature
//! gives the variances.

use nalgebra::{SMatrix, SVector};

use super::arm::KnownParameters;
use super::cost::WindowFit;
use super::quantity::{COUNT, PER_JOINT};
use super::stage::Stage;

/// Most Newton steps.
pub(super) const STEPS: usize = 8;
/// Reduction of the loss by the last step: a third of a standard error.
pub(super) const TOLERANCE: f64 = 0.1;
/// Standard errors by which a significant parameter exceeds zero.
pub(super) const SIGNIFICANT_SIGMAS: f64 = 3.0;

/// Result of the fit of a form.
pub(super) struct FormFit<E> {
    pub(super) estimate: E,
    /// The joint's other coordinates at the minimum.
    pub(super) own_coordinates: [f64; PER_JOINT],
    /// Covariance that the uncertainty of the form adds to the other parameters.
    pub(super) covariance: SMatrix<f64, COUNT, COUNT>,
}

/// A point of the profile.
pub(super) struct Point {
    pub(super) loss: f64,
    /// The coordinates fitted there.
    pub(super) coordinates: [f64; COUNT],
    /// Part of each window in the loss.
    window_losses: Vec<f64>,
}

/// See the [module](self).
pub(super) struct Profile<'a> {
    stage: &'a Stage<'a>,
    window_fits: Vec<WindowFit>,
    joint: usize,
}

impl<'a> Profile<'a> {
    /// The profile of a joint.
    pub(super) fn new(stage: &'a Stage<'a>, joint: usize) -> Self {
        Self {
            stage,
            window_fits: stage.joint_window_fits(joint),
            joint,
        }
    }

    /// The point with these forms of friction, from these coordinates.
    pub(super) fn evaluate(&self, known: &KnownParameters, coordinates: [f64; COUNT]) -> Point {
        let stage = Stage {
            known,
            window_fits: Vec::new(),
            ..*self.stage
        };
        let search = stage.search_in(self.window_fits.clone(), coordinates);
        let search = search.minimise_briefly();
        Point {
            loss: search.loss(),
            coordinates: search.coordinates(),
            window_losses: search.window_losses(),
        }
    }

    /// Variance of a parameter of the form with this second derivative of the loss, from points so
    /// far apart: that of noise, increased where the windows' derivatives scatter more than noise
    /// does.
    pub(super) fn variance(curvature: f64, above: &Point, below: &Point, distance: f64) -> f64 {
        // The loss is twice the negative logarithm of the likelihood.
        let information = 0.5 * curvature;
        let differences = above.window_losses.iter().zip(&below.window_losses);
        let scores = differences.map(|(above, below)| 0.5 * (above - below) / distance);
        let scatter: f64 = scores.map(|score| score * score).sum();
        (scatter / information.powi(2)).max(1.0 / information)
    }

    /// What is known without the form.
    pub(super) fn known(&self) -> KnownParameters {
        *self.stage.known
    }

    /// Derivatives of the joint's coordinates by a parameter of the form, from points so far apart.
    pub(super) fn sensitivity(
        &self,
        above: &Point,
        below: &Point,
        distance: f64,
    ) -> SVector<f64, COUNT> {
        SVector::from_fn(|i, _| {
            if i / PER_JOINT == self.joint {
                (above.coordinates[i] - below.coordinates[i]) / distance
            } else {
                0.0
            }
        })
    }

    /// The joint's coordinates after the last step, which moves them by `change`.
    pub(super) fn own_coordinates(
        &self,
        coordinates: &[f64; COUNT],
        change: &SVector<f64, COUNT>,
    ) -> [f64; PER_JOINT] {
        core::array::from_fn(|i| {
            let i = self.joint * PER_JOINT + i;
            coordinates[i] + change[i]
        })
    }
}
