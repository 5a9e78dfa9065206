//! Fits of each experiment: the paper's, and those with dry friction.
//!
//! If the initial state is known only from samples, the paper's fits treat it as known, as
//! the paper did; all others estimate it.

use serde::Serialize;

use super::fit::{Fit, FitError, fit};
use super::form_check::FormCheck;
use super::joint_parameters::{
    JointParameters, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VISCOUS_TORQUE_COULOMB,
};
use super::sampled_experiment::{ExperimentKind, InitialState, SampledExperiment};

/// Friction model of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionModel {
    /// The paper's: viscous friction.
    ViscousOnly,
    /// Viscous and Coulomb friction.
    WithDryFriction,
}

impl FrictionModel {
    /// Name for messages and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ViscousOnly => "viscous only",
            Self::WithDryFriction => "with dry friction",
        }
    }
}

/// Failure of the fit of an experiment.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{model} fit of the {experiment}: {source}", model = model.name())]
pub struct ExperimentError {
    /// Friction model.
    model: FrictionModel,
    /// Name of the experiment.
    experiment: &'static str,
    /// Cause.
    source: FitError,
}

/// Fits of the free falls.
pub(super) struct FallFits {
    /// The paper's.
    pub(super) as_paper: Fit,
    pub(super) dry: Fit,
    pub(super) form: FormCheck,
}

impl FallFits {
    /// Fits the free falls; none if there are none.
    pub(super) fn fit(
        falls: &[SampledExperiment],
        guess: &JointParameters,
    ) -> Result<Option<Self>, ExperimentError> {
        if falls.is_empty() {
            return Ok(None);
        }
        let try_fit = |sampled: &[SampledExperiment], unknowns, guess: &JointParameters, model| {
            try_fit(
                sampled,
                unknowns,
                guess,
                model,
                ExperimentKind::FreeFall.name(),
            )
        };
        let [viscous_only, with_dry] = [FrictionModel::ViscousOnly, FrictionModel::WithDryFriction];
        let as_paper = try_fit(&with_known_start(falls), VISCOUS, guess, viscous_only)?;
        let viscous = try_fit(falls, VISCOUS, guess, viscous_only)?;
        // Half the smallest initial gravity torque, so that the guessed arm does not stick.
        let coulomb_nm = falls.iter().map(|fall| {
            let gravity_nm = guess.gravity_nm * fall.start_rad.sin();
            0.5 * gravity_nm.abs()
        });
        let guess = JointParameters {
            coulomb_nm: coulomb_nm.fold(f64::INFINITY, f64::min),
            ..*guess
        };
        let dry = try_fit(falls, VISCOUS_COULOMB, &guess, with_dry)?;
        Ok(Some(Self {
            as_paper,
            form: FormCheck::compare(&viscous, &dry),
            dry,
        }))
    }
}

/// Fits of the constant inputs.
pub(super) struct PushFits {
    /// The paper's.
    pub(super) as_paper: Fit,
    /// Direction of the motion: 1 or -1.
    pub(super) direction: f64,
    pub(super) unidentifiable: Option<String>,
}

impl PushFits {
    /// Fits the constant inputs; none if there are none.
    pub(super) fn fit(
        pushes: &[SampledExperiment],
        guess: &JointParameters,
    ) -> Result<Option<Self>, ExperimentError> {
        /// Guess of dry friction, which is not identifiable here.
        const COULOMB_NM: f64 = 0.01;

        let Some((_, last_rad)) = pushes.first().and_then(|push| push.points().last()) else {
            return Ok(None);
        };
        let direction = (last_rad - pushes[0].start_rad).signum();
        let kind = ExperimentKind::ConstantInput.name();
        let model = FrictionModel::ViscousOnly;
        let pushes = with_known_start(pushes);
        let as_paper = try_fit(&pushes, VISCOUS_TORQUE, guess, model, kind)?;
        let guess = JointParameters {
            coulomb_nm: COULOMB_NM,
            torque_nm: as_paper.parameters.torque_nm + direction * COULOMB_NM,
            ..as_paper.parameters
        };
        let dry = fit(&pushes, VISCOUS_TORQUE_COULOMB, &guess);
        Ok(Some(Self {
            as_paper,
            direction,
            unidentifiable: dry.ok().and_then(|fit| fit.unidentifiable()),
        }))
    }
}

/// Fit of one arm to all experiments.
pub(super) fn combined_fit(
    fall: &FallFits,
    falls: &[SampledExperiment],
    push: &PushFits,
    pushes: &[SampledExperiment],
) -> Result<Fit, ExperimentError> {
    let guess = JointParameters {
        // The constant input gives the motor's torque minus dry friction.
        torque_nm: push.as_paper.parameters.torque_nm
            + push.direction * fall.dry.parameters.coulomb_nm,
        ..fall.dry.parameters
    };
    let all = [falls, pushes].concat();
    let model = FrictionModel::WithDryFriction;
    try_fit(&all, VISCOUS_TORQUE_COULOMB, &guess, model, "two together")
}

/// The experiments with the measured initial state treated as known.
fn with_known_start(sampled: &[SampledExperiment]) -> Vec<SampledExperiment> {
    let known = |sampled: &SampledExperiment| SampledExperiment {
        start: InitialState::Known,
        ..sampled.clone()
    };
    sampled.iter().map(known).collect()
}

fn try_fit(
    sampled: &[SampledExperiment],
    unknowns: &[Unknown],
    guess: &JointParameters,
    model: FrictionModel,
    experiment: &'static str,
) -> Result<Fit, ExperimentError> {
    fit(sampled, unknowns, guess).map_err(|source| ExperimentError {
        model,
        experiment,
        source,
    })
}
