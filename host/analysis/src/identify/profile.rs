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

/// Loss, and the coordinates fitted there.
pub(super) type Point = (f64, [f64; COUNT]);

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
        (search.loss(), search.coordinates())
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
                (above.1[i] - below.1[i]) / distance
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
