//! Both experiments, fitted as the paper did and with dry friction: two values, and one.

use armbridge_shared::arm::Parameters;
use serde::Serialize;

use super::experiment_fits::{ExperimentError, FallFits, Model, PushFits, both};
use super::fit::Fit;
use super::form::Form;
use super::numbers::{Numbers, Unknown};
use super::sampled::{Kind, Sampled};
use super::virtual_arm::VirtualArm;
use crate::paper::printed;

/// Standard errors to either side in which a number is with 95 %.
const INTERVAL: f64 = 1.96;
/// Dry friction in N m with which the arm that the constant input found falls like one of
/// the paper's b1 of the free fall; see [`Fall`](crate::paper::Fall), which seeks it.
const COULOMB_NM: f64 = 0.107285;
/// How long the virtual arm is pushed, in s: the table stopped the paper's.
const PUSH_S: f64 = 1.3;

/// A number that was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Within {
    /// What was found.
    pub value: f64,
    /// Half of its 95 % interval, if the model is of the right form.
    pub within: f64,
}

/// One fit of one experiment or of both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Of which; none for both together.
    pub experiment: Option<Kind>,
    /// By which model.
    pub model: Model,
    /// Viscous friction in N m s/rad.
    pub b1: Within,
    /// Dry friction in N m, where it was sought.
    pub coulomb_nm: Option<Within>,
    /// The constant input in N m, where there is one.
    pub torque_nm: Option<Within>,
    /// Root mean square of the residuals in mrad.
    pub rms_mrad: f64,
    /// What the paper prints: b1, and torque.
    pub paper: Option<[Option<f64>; 2]>,
}

/// What the paper's procedure gives, and what is behind it.
#[derive(Clone, Debug, Serialize)]
pub struct PaperComparison {
    /// Whose samples these are.
    pub source: String,
    /// Between samples, in s.
    pub period_s: f64,
    /// The fits.
    pub lines: Vec<Line>,
    /// What the free fall's residuals say of viscous friction alone.
    pub form: Option<Form>,
    /// Torque of the motor in the constant input, by the board's calibration, in N m.
    pub told_nm: Option<f64>,
    /// What the constant input alone cannot tell, if dry friction is sought in it.
    pub blind_spot: Option<String>,
    /// The samples, with the residuals of both models.
    #[serde(skip)]
    pub(super) shown: Vec<Shown>,
}

/// An experiment, and both models of it.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    pub(super) sampled: Sampled,
    /// Measured less computed in rad, by the viscous model.
    pub(super) viscous_rad: Vec<Option<f64>>,
    /// The same by the model with dry friction, where there is a fit.
    pub(super) dry_rad: Option<Vec<Option<f64>>>,
}

/// Why there is nothing to compare.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// No experiment.
    #[error("there is no experiment to fit")]
    Nothing,
    /// The constant inputs differ.
    #[error(
        "the constant inputs are of {0:+.4} and {1:+.4} N m: they are fitted as one torque; give \
         logs of one"
    )]
    Torques(f64, f64),
    /// A fit failed.
    #[error(transparent)]
    Fit(#[from] ExperimentError),
}

impl PaperComparison {
    /// The paper's two experiments on the virtual arm that gives its two values.
    ///
    /// # Errors
    /// If a fit fails, which would be a mistake of the library.
    pub fn simulated(seed: u64) -> Result<Self, CompareError> {
        let arm = VirtualArm::paper(printed::B1_PUSH, COULOMB_NM, seed);
        let fall = arm.paper_fall();
        // So that as much is left over for the arm as the paper found.
        let push = arm.constant_input(printed::PUSH_NM - COULOMB_NM, PUSH_S);
        let source = format!(
            "simulated: the paper's arm with b1 = {} N m s/rad and {COULOMB_NM} N m of dry \
             friction, seed {seed}",
            printed::B1_PUSH
        );
        Self::of(source, vec![fall, push], &arm.arm)
    }

    /// Of experiments on an arm whose inertia and weight are these.
    ///
    /// # Errors
    /// See [`CompareError`].
    pub fn of(
        source: String,
        sampled: Vec<Sampled>,
        arm: &Parameters<f64>,
    ) -> Result<Self, CompareError> {
        let period_s = sampled.first().ok_or(CompareError::Nothing)?.period_s;
        let torques_nm = sampled.iter().filter_map(|sampled| sampled.told_nm);
        let torques_nm: Vec<f64> = torques_nm.collect();
        if let [first, others @ ..] = torques_nm.as_slice()
            && let Some(other) = others.iter().find(|other| (*other - first).abs() > 1e-9)
        {
            return Err(CompareError::Torques(*first, *other));
        }
        let (falls, pushes): (Vec<Sampled>, Vec<Sampled>) = sampled
            .into_iter()
            .partition(|sampled| sampled.kind == Kind::FreeFall);
        let told_nm = torques_nm.first().copied();
        let begin = Numbers {
            torque_nm: told_nm.unwrap_or(0.0),
            ..Numbers::of(arm)
        };
        let fall = FallFits::of(&falls, &begin)?;
        let push = PushFits::of(&pushes, &begin)?;
        let both = match (&fall, &push) {
            (Some(fall), Some(push)) => Some(both(fall, &falls, push, &pushes)?),
            (Some(_), None) | (None, Some(_) | None) => None,
        };

        let [viscous_only, with_dry] = [Model::ViscousOnly, Model::WithDryFriction];
        let mut lines = Vec::new();
        if let Some(fall) = &fall {
            let paper = Some([Some(printed::B1_FALL), None]);
            lines.push(line(
                Some(Kind::FreeFall),
                viscous_only,
                &fall.as_paper,
                paper,
            ));
        }
        if let Some(push) = &push {
            let paper = Some([Some(printed::B1_PUSH), Some(printed::PUSH_NM)]);
            let kind = Some(Kind::ConstantInput);
            lines.push(line(kind, viscous_only, &push.as_paper, paper));
        }
        if let Some(fall) = &fall {
            lines.push(line(Some(Kind::FreeFall), with_dry, &fall.dry, None));
        }
        if let Some(both) = &both {
            lines.push(line(None, with_dry, both, None));
        }
        let form = fall.as_ref().map(|fall| fall.form);
        let blind_spot = push.as_ref().and_then(|push| push.blind_spot.clone());

        // Falls come first in the fit of both.
        let viscous = fall.iter().map(|fall| &fall.as_paper);
        let viscous = viscous.chain(push.iter().map(|push| &push.as_paper));
        let viscous = viscous.flat_map(|fit| fit.residuals_rad.iter().cloned());
        let dry: Vec<&Fit> = match &both {
            Some(both) => vec![both],
            None => fall.iter().map(|fall| &fall.dry).collect(),
        };
        let mut dry = dry
            .into_iter()
            .flat_map(|fit| fit.residuals_rad.iter().cloned());
        let shown = falls.into_iter().chain(pushes).zip(viscous);
        let shown = shown.map(|(sampled, viscous)| Shown {
            sampled,
            viscous_rad: viscous,
            dry_rad: dry.next(),
        });
        Ok(Self {
            source,
            period_s,
            lines,
            form,
            told_nm,
            blind_spot,
            shown: shown.collect(),
        })
    }

    /// The fit of this, if there was one.
    pub fn line(&self, experiment: Option<Kind>, model: Model) -> Option<&Line> {
        let is_it = |line: &&Line| line.experiment == experiment && line.model == model;
        self.lines.iter().find(is_it)
    }
}

fn line(
    experiment: Option<Kind>,
    model: Model,
    fit: &Fit,
    paper: Option<[Option<f64>; 2]>,
) -> Line {
    let number = |unknown| {
        fit.unknowns.contains(&unknown).then(|| Within {
            value: fit.numbers.get(unknown),
            within: INTERVAL * fit.error(unknown),
        })
    };
    Line {
        experiment,
        model,
        b1: Within {
            value: fit.numbers.b1,
            within: INTERVAL * fit.error(Unknown::Viscous),
        },
        coulomb_nm: number(Unknown::Coulomb),
        torque_nm: number(Unknown::Torque),
        rms_mrad: 1e3 * fit.rms_rad,
        paper,
    }
}
