//! Comparison of the paper's fits of both experiments, which give two values of b1, with fits
//! that include dry friction, which give one.

use armbridge_control::arm::Parameters;
use serde::Serialize;

use super::experiment_fits::{ExperimentError, FallFits, FrictionModel, PushFits, combined_fit};
use super::fit::Fit;
use super::form_check::FormCheck;
use super::joint_parameters::{JointParameters, Unknown};
use super::sampled_experiment::{ExperimentKind, SampledExperiment};
use super::virtual_arm::VirtualArm;
use crate::printed;

/// Half-width of a 95 % confidence interval in standard errors.
const INTERVAL: f64 = 1.96;
/// Dry friction in N m with which a free fall of the arm that the constant input identified
/// gives the paper's b1 of the free fall; computed by
/// [`FreeFall`](crate::FreeFall).
const COULOMB_NM: f64 = 0.107285;
/// Duration of the virtual arm's push in s: the table stopped the paper's arm.
const PUSH_S: f64 = 1.3;

/// An estimated parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Estimate.
    pub value: f64,
    /// Half-width of its 95 % confidence interval, valid if the model is of the right form.
    #[serde(rename = "within")]
    pub half_width: f64,
}

/// One fit of one experiment or of both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitSummary {
    /// Experiment; none for both together.
    pub experiment: Option<ExperimentKind>,
    /// Friction model.
    pub model: FrictionModel,
    /// Viscous friction in N m s/rad.
    pub b1: Estimate,
    /// Dry friction in N m, if it was fitted.
    pub coulomb_nm: Option<Estimate>,
    /// The constant input in N m, if it was fitted.
    pub torque_nm: Option<Estimate>,
    /// Root mean square of the residuals in mrad.
    pub rms_mrad: f64,
    /// Printed values of b1 and torque.
    pub paper: Option<[Option<f64>; 2]>,
}

/// Results of the paper's procedure and of the fits with dry friction.
#[derive(Clone, Debug, Serialize)]
pub struct PaperComparison {
    /// Origin of the samples.
    pub source: String,
    /// Sampling period in s.
    pub period_s: f64,
    /// The fits.
    #[serde(rename = "lines")]
    pub fits: Vec<FitSummary>,
    /// Residual check of the free fall's fit with viscous friction alone.
    pub form: Option<FormCheck>,
    /// Motor torque of the constant input in N m, by the board's calibration.
    pub commanded_nm: Option<f64>,
    /// Parameters that the constant input alone cannot identify if dry friction is among them.
    pub unidentifiable: Option<String>,
    /// The samples, with the residuals of both models.
    #[serde(skip)]
    pub(super) experiments: Vec<FittedExperiment>,
}

/// An experiment with the residuals of both models.
#[derive(Clone, Debug)]
pub(super) struct FittedExperiment {
    pub(super) sampled: SampledExperiment,
    /// Measured minus computed angles in rad, by the viscous model.
    pub(super) viscous_rad: Vec<Option<f64>>,
    /// Measured minus computed angles in rad, by the model with dry friction, if it was fitted.
    pub(super) dry_rad: Option<Vec<Option<f64>>>,
}

/// Reason why there is no comparison.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// No experiment.
    #[error("there is no experiment to fit")]
    NoExperiment,
    /// The constant inputs differ.
    #[error(
        "the constant inputs are {0:+.4} and {1:+.4} N m, but one torque is fitted; give logs of \
         one torque only"
    )]
    Torques(f64, f64),
    /// A fit failed.
    #[error(transparent)]
    Fit(#[from] ExperimentError),
}

impl PaperComparison {
    /// Simulates and fits the paper's two experiments on the virtual arm that gives its two
    /// values of b1.
    ///
    /// # Errors
    /// If a fit fails, which only a defect of the library can cause.
    pub fn simulated(seed: u64) -> Result<Self, CompareError> {
        let arm = VirtualArm::paper(printed::B1_PUSH, COULOMB_NM, seed);
        let fall = arm.paper_fall();
        // The motor torque minus dry friction is the paper's torque.
        let push = arm.constant_input(printed::PUSH_NM - COULOMB_NM, PUSH_S);
        let source = format!(
            "simulated: the paper's arm with b1 = {} N m s/rad and {COULOMB_NM} N m of dry \
             friction, seed {seed}",
            printed::B1_PUSH
        );
        Self::from_experiments(source, vec![fall, push], &arm.arm)
    }

    /// Fits experiments on an arm with the inertia and weight of `arm`.
    ///
    /// # Errors
    /// See [`CompareError`].
    pub fn from_experiments(
        source: String,
        sampled: Vec<SampledExperiment>,
        arm: &Parameters<f64>,
    ) -> Result<Self, CompareError> {
        let period_s = sampled.first().ok_or(CompareError::NoExperiment)?.period_s;
        let torques_nm = sampled.iter().filter_map(|sampled| sampled.commanded_nm);
        let torques_nm: Vec<f64> = torques_nm.collect();
        if let [first, others @ ..] = torques_nm.as_slice()
            && let Some(other) = others.iter().find(|other| (*other - first).abs() > 1e-9)
        {
            return Err(CompareError::Torques(*first, *other));
        }
        let (falls, pushes): (Vec<SampledExperiment>, Vec<SampledExperiment>) = sampled
            .into_iter()
            .partition(|sampled| sampled.kind == ExperimentKind::FreeFall);
        let commanded_nm = torques_nm.first().copied();
        let guess = JointParameters {
            torque_nm: commanded_nm.unwrap_or(0.0),
            ..JointParameters::from_arm(arm)
        };
        let fall = FallFits::fit(&falls, &guess)?;
        let push = PushFits::fit(&pushes, &guess)?;
        let combined = match (&fall, &push) {
            (Some(fall), Some(push)) => Some(combined_fit(fall, &falls, push, &pushes)?),
            (Some(_), None) | (None, Some(_) | None) => None,
        };

        let [viscous_only, with_dry] = [FrictionModel::ViscousOnly, FrictionModel::WithDryFriction];
        let mut fits = Vec::new();
        if let Some(fall) = &fall {
            let paper = Some([Some(printed::B1_FALL), None]);
            fits.push(summary(
                Some(ExperimentKind::FreeFall),
                viscous_only,
                &fall.as_paper,
                paper,
            ));
        }
        if let Some(push) = &push {
            let paper = Some([Some(printed::B1_PUSH), Some(printed::PUSH_NM)]);
            let kind = Some(ExperimentKind::ConstantInput);
            fits.push(summary(kind, viscous_only, &push.as_paper, paper));
        }
        if let Some(fall) = &fall {
            fits.push(summary(
                Some(ExperimentKind::FreeFall),
                with_dry,
                &fall.dry,
                None,
            ));
        }
        if let Some(combined) = &combined {
            fits.push(summary(None, with_dry, combined, None));
        }
        let form = fall.as_ref().map(|fall| fall.form);
        let unidentifiable = push.as_ref().and_then(|push| push.unidentifiable.clone());

        // Falls come first in the combined fit.
        let viscous = fall.iter().map(|fall| &fall.as_paper);
        let viscous = viscous.chain(push.iter().map(|push| &push.as_paper));
        let viscous = viscous.flat_map(|fit| fit.residuals_rad.iter().cloned());
        let dry: Vec<&Fit> = match &combined {
            Some(combined) => vec![combined],
            None => fall.iter().map(|fall| &fall.dry).collect(),
        };
        let mut dry = dry
            .into_iter()
            .flat_map(|fit| fit.residuals_rad.iter().cloned());
        let experiments = falls.into_iter().chain(pushes).zip(viscous);
        let experiments = experiments.map(|(sampled, viscous)| FittedExperiment {
            sampled,
            viscous_rad: viscous,
            dry_rad: dry.next(),
        });
        Ok(Self {
            source,
            period_s,
            fits,
            form,
            commanded_nm,
            unidentifiable,
            experiments: experiments.collect(),
        })
    }

    /// The fit of an experiment, or of both if `None`, by a model, if there is one.
    pub fn fit(
        &self,
        experiment: Option<ExperimentKind>,
        model: FrictionModel,
    ) -> Option<&FitSummary> {
        let mut fits = self.fits.iter();
        fits.find(|fit| fit.experiment == experiment && fit.model == model)
    }
}

fn summary(
    experiment: Option<ExperimentKind>,
    model: FrictionModel,
    fit: &Fit,
    paper: Option<[Option<f64>; 2]>,
) -> FitSummary {
    let estimate = |unknown| {
        fit.unknowns.contains(&unknown).then(|| Estimate {
            value: fit.parameters.get(unknown),
            half_width: INTERVAL * fit.standard_error(unknown),
        })
    };
    FitSummary {
        experiment,
        model,
        b1: Estimate {
            value: fit.parameters.b1,
            half_width: INTERVAL * fit.standard_error(Unknown::Viscous),
        },
        coulomb_nm: estimate(Unknown::Coulomb),
        torque_nm: estimate(Unknown::Torque),
        rms_mrad: 1e3 * fit.rms_rad,
        paper,
    }
}
