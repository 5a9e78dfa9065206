//! Input of the procedure: evenly sampled angles of joint 1, from its release or from the
//! start of the constant input.

use serde::Serialize;

use crate::printed::PERIOD_S;

/// One of the paper's two experiments on joint 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ExperimentKind {
    /// Section 3, Fig. 5: released away from upright, motor off.
    FreeFall,
    /// Section 3, Fig. 6: constant torque.
    ConstantInput,
}

impl ExperimentKind {
    /// The paper's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FreeFall => "free fall",
            Self::ConstantInput => "constant input",
        }
    }
}

/// Knowledge of the initial state of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialState {
    /// The angle is known, and the arm is at rest.
    Known,
    /// The angle is estimated; the arm is at rest.
    AtRest,
    /// Angle and speed are estimated: an arm held in air is never exactly at rest.
    Estimated,
}

impl InitialState {
    /// Number of estimated components: none, the angle, or the angle and the speed.
    pub(super) const fn unknowns(self) -> usize {
        match self {
            Self::Known => 0,
            Self::AtRest => 1,
            Self::Estimated => 2,
        }
    }
}

/// Samples of one experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledExperiment {
    /// Experiment.
    pub kind: ExperimentKind,
    /// Sampling period in s.
    pub period_s: f64,
    /// Angles in rad; none where a sample is missing. The first is at the start.
    pub angles_rad: Vec<Option<f64>>,
    /// Start angle of joint 1 in rad, at rest or nearly so.
    pub start_rad: f64,
    /// Components of the initial state that are known better than from the samples.
    pub start: InitialState,
    /// Torque of the motor's PWM in N m, if it is known.
    pub commanded_nm: Option<f64>,
}

impl SampledExperiment {
    /// Number of samples present.
    pub fn count(&self) -> usize {
        self.angles_rad.iter().flatten().count()
    }

    /// Downsamples to the paper's period.
    #[must_use]
    pub fn at_paper_period(&self) -> Self {
        let n = (PERIOD_S / self.period_s).round().max(1.0) as usize;
        Self {
            period_s: self.period_s * n as f64,
            angles_rad: self.angles_rad.iter().copied().step_by(n).collect(),
            ..self.clone()
        }
    }

    /// Times in s and angles in rad of the samples present.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let angles = self.angles_rad.iter().enumerate();
        angles.filter_map(|(k, angle)| Some((k as f64 * self.period_s, (*angle)?)))
    }
}
