//! Forms of dry friction beside Coulomb's: which of them a joint has.
//!
//! Each is tested by the torque that it would add ([`Checks`](super::Checks)). The one that improves
//! the fit of a joint most is fitted, if it does so significantly; then the other is tested again, with
//! the first one in the model. So a form is chosen for what no other explains.

use armbridge_servo::JOINTS;
use nalgebra::SMatrix;

use super::arm::KnownParameters;
use super::checks;
use super::fit_result::FitResult;
use super::load::{LoadEstimate, fit_load};
use super::quantity::{COUNT, PER_JOINT};
use super::stage::Stage;
use super::stribeck::fit_stribeck;
use super::stribeck_curve::StribeckCurve;

/// A form, and its initial guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FrictionForm {
    /// Dry friction falls with speed.
    Stribeck(StribeckCurve),
    /// Dry friction grows with the torque on the gears.
    Load(LoadEstimate),
}

/// Number of forms.
const FORMS: usize = 2;

impl FitResult {
    /// Selects the forms of a joint's dry friction, and fits them; keeps the load of the initial
    /// guess only if it is significant.
    pub(super) fn select_friction(&mut self, stage: &Stage<'_>, joint: usize) {
        self.refit_load(stage, joint);
        for _ in 0..FORMS {
            let known = stage.known.with_friction(self);
            let form = checks::friction_candidate(self, stage.traces, &known, joint);
            if form.is_none_or(|form| self.fit_form(stage, joint, form).is_none()) {
                break;
            }
        }
    }

    /// Fits a joint's load again, if it has one; without one if it is not significant.
    pub(super) fn refit_load(&mut self, stage: &Stage<'_>, joint: usize) {
        if let Some(load) = self.load[joint] {
            self.fit_form(stage, joint, FrictionForm::Load(load));
        }
    }

    /// Whether a joint has any.
    pub(super) fn has_friction_form(&self) -> bool {
        let is_any = |joint: usize| self.stribeck[joint].is_some() || self.load[joint].is_some();
        (0..JOINTS).any(is_any)
    }

    /// Fits the forms of a joint again. Returns the covariance that their uncertainty adds to the
    /// other parameters.
    pub(super) fn refit_friction(
        &mut self,
        stage: &Stage<'_>,
        joint: usize,
    ) -> SMatrix<f64, COUNT, COUNT> {
        // A load is fitted again with the curve that was fitted with it.
        let rounds = match (self.load[joint], self.stribeck[joint]) {
            (Some(_), Some(_)) => 2,
            _ => 1,
        };
        let mut added = [SMatrix::zeros(); FORMS];
        for _ in 0..rounds {
            let load = self.load[joint].map(FrictionForm::Load);
            let curve = self.stribeck[joint].map(|curve| FrictionForm::Stribeck(curve.curve()));
            for (form, added) in [load, curve].into_iter().zip(&mut added) {
                let covariance = form.and_then(|form| self.fit_form(stage, joint, form));
                *added = covariance.unwrap_or_else(SMatrix::zeros);
            }
        }
        added.iter().sum()
    }

    /// Fits a form of a joint, with the others as they are. Returns the covariance that its
    /// uncertainty adds to the other parameters; `None` if the joint has no such form.
    fn fit_form(
        &mut self,
        stage: &Stage<'_>,
        joint: usize,
        form: FrictionForm,
    ) -> Option<SMatrix<f64, COUNT, COUNT>> {
        match form {
            FrictionForm::Stribeck(_) => self.stribeck[joint] = None,
            FrictionForm::Load(_) => self.load[joint] = None,
        }
        let known = stage.known.with_friction(self);
        let stage = Stage {
            known: &known,
            window_fits: stage.window_fits.clone(),
            ..*stage
        };
        let (own_coordinates, covariance) = match form {
            FrictionForm::Stribeck(initial) => {
                let fit = fit_stribeck(&stage, self.coordinates, joint, initial)?;
                self.stribeck[joint] = Some(fit.estimate);
                (fit.own_coordinates, fit.covariance)
            }
            FrictionForm::Load(initial) => {
                let fit = fit_load(&stage, self.coordinates, joint, initial)?;
                self.load[joint] = Some(fit.estimate);
                (fit.own_coordinates, fit.covariance)
            }
        };
        let own = joint * PER_JOINT..(joint + 1) * PER_JOINT;
        self.coordinates[own].copy_from_slice(&own_coordinates);
        Some(covariance)
    }
}

impl KnownParameters {
    /// The same with the forms of dry friction of a fit.
    #[must_use]
    pub(super) fn with_friction(&self, fit: &FitResult) -> Self {
        Self {
            stribeck: fit.stribeck.map(|curve| curve.map(|curve| curve.curve())),
            load: fit.load.map(|load| load.map_or(0.0, |load| load.load)),
            ..*self
        }
    }
}
