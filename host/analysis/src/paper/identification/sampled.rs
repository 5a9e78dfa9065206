//! What the procedure is given: angles of joint 1 at even times, from where it was let go
//! or where the constant input began.

use serde::Serialize;

use crate::paper::printed::PERIOD_S;

/// Which of the paper's two experiments on joint 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Section 3, Fig. 5: let go off upright, motor off.
    FreeFall,
    /// Section 3, Fig. 6: one torque all the time.
    ConstantInput,
}

impl Kind {
    /// As the paper calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FreeFall => "free fall",
            Self::ConstantInput => "constant input",
        }
    }
}

/// What is known of the start of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Where it is, and that it is at rest.
    Known,
    /// That it is at rest; where is found.
    AtRest,
    /// Where and how fast is found: an arm is never quite at rest that is held in air.
    Found,
}

impl Start {
    /// Numbers that are found: none, the angle, or the angle and the speed.
    pub(super) const fn unknowns(self) -> usize {
        match self {
            Self::Known => 0,
            Self::AtRest => 1,
            Self::Found => 2,
        }
    }
}

/// One experiment, sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    /// Which.
    pub kind: Kind,
    /// Between samples, in s.
    pub period_s: f64,
    /// In rad; none where a sample is missing. The first is at the start.
    pub angles_rad: Vec<Option<f64>>,
    /// Where joint 1 is at first, in rad, at rest or nearly.
    pub start_rad: f64,
    /// Whether that is known to better than the samples tell, and that it is at rest.
    pub start: Start,
    /// Torque in N m of the motor's PWM, where it is known.
    pub told_nm: Option<f64>,
}

impl Sampled {
    /// Samples that are not missing.
    pub fn count(&self) -> usize {
        self.angles_rad.iter().flatten().count()
    }

    /// As rare as the paper's, by leaving samples out.
    #[must_use]
    pub fn as_paper(&self) -> Self {
        let n = (PERIOD_S / self.period_s).round().max(1.0) as usize;
        Self {
            period_s: self.period_s * n as f64,
            angles_rad: self.angles_rad.iter().copied().step_by(n).collect(),
            ..self.clone()
        }
    }

    /// Times in s and angles in rad of samples that are not missing.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let angles = self.angles_rad.iter().enumerate();
        angles.filter_map(|(k, angle)| Some((k as f64 * self.period_s, (*angle)?)))
    }
}
