//! The fits of each experiment: the paper's, and those with dry friction.
//!
//! Where the start is only as good as the samples before it tell, the paper's fits take it
//! as known, as the paper did; all others find it.

use serde::Serialize;

use super::fit::{Fit, FitError, fit};
use super::form::Form;
use super::numbers::{
    Numbers, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VISCOUS_TORQUE_COULOMB,
};
use super::sampled::{Kind, Sampled, Start};

/// What a fit knows of friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// The paper's.
    ViscousOnly,
    /// With Coulomb friction.
    WithDryFriction,
}

impl Model {
    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ViscousOnly => "viscous only",
            Self::WithDryFriction => "with dry friction",
        }
    }
}

/// Why an experiment was not fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{model} fit of the {experiment}: {source}", model = model.name())]
pub struct ExperimentError {
    /// By which model.
    model: Model,
    /// Of what.
    experiment: &'static str,
    /// Why.
    source: FitError,
}

/// Fits of the free falls.
pub(super) struct FallFits {
    /// The paper's.
    pub(super) as_paper: Fit,
    pub(super) dry: Fit,
    pub(super) form: Form,
}

impl FallFits {
    /// None without any.
    pub(super) fn of(falls: &[Sampled], begin: &Numbers) -> Result<Option<Self>, ExperimentError> {
        if falls.is_empty() {
            return Ok(None);
        }
        let try_fit = |sampled: &[Sampled], unknowns, begin: &Numbers, model| {
            try_fit(sampled, unknowns, begin, model, Kind::FreeFall.name())
        };
        let [viscous_only, with_dry] = [Model::ViscousOnly, Model::WithDryFriction];
        let as_paper = try_fit(&known(falls), VISCOUS, begin, viscous_only)?;
        let viscous = try_fit(falls, VISCOUS, begin, viscous_only)?;
        // With more than what holds one of them, the arm of the guess would stick.
        let loosest_nm = falls.iter().map(|fall| {
            let push_nm = begin.gravity_nm * fall.start_rad.sin();
            0.5 * push_nm.abs()
        });
        let begin = Numbers {
            coulomb_nm: loosest_nm.fold(f64::INFINITY, f64::min),
            ..*begin
        };
        let dry = try_fit(falls, VISCOUS_COULOMB, &begin, with_dry)?;
        Ok(Some(Self {
            as_paper,
            form: Form::of(&viscous, &dry),
            dry,
        }))
    }
}

/// Fits of the constant inputs.
pub(super) struct PushFits {
    /// The paper's.
    pub(super) as_paper: Fit,
    /// Which way the arm goes.
    pub(super) way: f64,
    pub(super) blind_spot: Option<String>,
}

impl PushFits {
    /// None without any.
    pub(super) fn of(pushes: &[Sampled], begin: &Numbers) -> Result<Option<Self>, ExperimentError> {
        /// Some dry friction to begin with: it will not be found.
        const SOME_NM: f64 = 0.01;

        let Some((_, last_rad)) = pushes.first().and_then(|push| push.points().last()) else {
            return Ok(None);
        };
        let way = (last_rad - pushes[0].start_rad).signum();
        let kind = Kind::ConstantInput.name();
        let model = Model::ViscousOnly;
        let as_paper = try_fit(&known(pushes), VISCOUS_TORQUE, begin, model, kind)?;
        let begin = Numbers {
            coulomb_nm: SOME_NM,
            torque_nm: as_paper.numbers.torque_nm + way * SOME_NM,
            ..as_paper.numbers
        };
        let dry = fit(&known(pushes), VISCOUS_TORQUE_COULOMB, &begin);
        Ok(Some(Self {
            as_paper,
            way,
            blind_spot: dry.ok().and_then(|fit| fit.blind_spot()),
        }))
    }
}

/// One arm for all experiments.
pub(super) fn both(
    fall: &FallFits,
    falls: &[Sampled],
    push: &PushFits,
    pushes: &[Sampled],
) -> Result<Fit, ExperimentError> {
    let begin = Numbers {
        // The constant input gives the motor's torque less dry friction.
        torque_nm: push.as_paper.numbers.torque_nm + push.way * fall.dry.numbers.coulomb_nm,
        ..fall.dry.numbers
    };
    let all = [falls, pushes].concat();
    let model = Model::WithDryFriction;
    try_fit(&all, VISCOUS_TORQUE_COULOMB, &begin, model, "two together")
}

/// The same, taken to begin where it was measured to.
fn known(sampled: &[Sampled]) -> Vec<Sampled> {
    let known = |sampled: &Sampled| Sampled {
        start: Start::Known,
        ..sampled.clone()
    };
    sampled.iter().map(known).collect()
}

fn try_fit(
    sampled: &[Sampled],
    unknowns: &[Unknown],
    begin: &Numbers,
    model: Model,
    experiment: &'static str,
) -> Result<Fit, ExperimentError> {
    fit(sampled, unknowns, begin).map_err(|source| ExperimentError {
        model,
        experiment,
        source,
    })
}
