//! Least-squares fit of the parameters of joint 1, with standard errors and identifiability.
//!
//! Unbounded Levenberg-Marquardt on the angles, with exact derivatives. The standard errors
//! assume white noise on each sample, with a variance estimated from the residuals; they are
//! not valid if the model is of the wrong form, see [`FormCheck`](super::FormCheck).
//!
//! The search cannot leave a guess at which friction holds the arm: nothing moves, so
//! the residuals depend on no parameter. Such a guess is rejected.

use nalgebra::{DMatrix, DVector};

use super::joint_parameters::{JointParameters, Unknown};
use super::least_squares::Problem;
use super::sampled_experiment::{ExperimentKind, SampledExperiment};
use armbridge_analysis::levenberg_marquardt::{End, Limits, minimise};

/// Condition number above which a combination of parameters is not identifiable: with exact
/// derivatives, the smallest singular value is then rounding.
const SINGULAR_CONDITION: f64 = 1e9;

/// Result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// All parameters, fitted or not.
    pub parameters: JointParameters,
    /// The fitted parameters.
    pub unknowns: Vec<Unknown>,
    /// Initial state of each experiment: angle in rad, speed in rad/s.
    pub starts: Vec<[f64; 2]>,
    /// Covariance of the unknowns, followed by the estimated initial states.
    pub covariance: DMatrix<f64>,
    /// Condition number of the Jacobian with respect to relative changes of the unknowns.
    pub condition: f64,
    /// Fraction of each unknown's variance that lies in the least observable direction.
    pub(super) weakest_share: Vec<f64>,
    /// Root mean square of all residuals, in rad.
    pub rms_rad: f64,
    /// Measured minus computed angles in rad, for each experiment; none where a sample is
    /// missing.
    pub residuals_rad: Vec<Vec<Option<f64>>>,
}

/// Failure of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Fewer samples than needed.
    #[error("{samples} samples are too few for {unknowns} unknown parameters")]
    TooFewSamples {
        /// Samples present.
        samples: usize,
        /// Unknowns, including those of the initial states.
        unknowns: usize,
    },
    /// The arm of the guess does not move in an experiment.
    #[error(
        "the arm sticks in the {} with the guessed dry friction, so no parameter has an effect; \
         guess less",
        kind.name()
    )]
    Sticks {
        /// The experiment.
        kind: ExperimentKind,
    },
    /// The search did not converge.
    #[error("the fit did not converge: do these samples show a moving arm?")]
    NotConverged,
}

impl Fit {
    /// Evaluates the problem at the end of the search.
    fn from_problem(problem: &Problem) -> Self {
        let parameters = problem.parameters();
        let starts = problem
            .starts()
            .into_iter()
            .map(|(start, _)| start)
            .collect();
        let (rows, columns) = problem.jacobian.shape();
        // Scales of relative changes.
        let size = DVector::from_fn(columns, |j, _| match problem.unknowns.get(j) {
            Some(unknown) => problem.x[j].abs().max(unknown.scale_floor()),
            None => problem.x[j].abs().max(0.05),
        });
        let scaled = DMatrix::from_fn(rows, columns, |i, j| problem.jacobian[(i, j)] * size[j]);
        let svd = scaled.svd(false, true);
        let values = &svd.singular_values;
        let largest = values.max();
        let smallest = values.min();
        let v_t = svd
            .v_t
            .unwrap_or_else(|| DMatrix::identity(columns, columns));
        let squares = problem.residuals.norm_squared();
        let variance = squares / (rows - columns) as f64;
        let weight = values.map(|value| variance / value.max(largest * 1e-15).powi(2));
        let least = values.imin();
        let weakest_share = (0..columns).map(|j| {
            let parts = (0..columns).map(|k| v_t[(k, j)].powi(2) * weight[k]);
            v_t[(least, j)].powi(2) * weight[least] / parts.sum::<f64>()
        });
        let weakest_share = weakest_share.collect();
        let relative = v_t.transpose() * DMatrix::from_diagonal(&weight) * &v_t;
        let covariance = DMatrix::from_fn(columns, columns, |i, j| {
            relative[(i, j)] * size[i] * size[j]
        });
        let mut residuals = problem.residuals.iter().copied();
        let residuals_rad = problem.sampled.iter().map(|sampled| {
            let angles = sampled.angles_rad.iter();
            angles
                .map(|angle| angle.and_then(|_| residuals.next()))
                .collect()
        });
        Self {
            parameters,
            unknowns: problem.unknowns.to_vec(),
            starts,
            residuals_rad: residuals_rad.collect(),
            covariance,
            condition: largest / smallest,
            weakest_share,
            rms_rad: (squares / rows as f64).sqrt(),
        }
    }

    /// Standard error of a parameter; 0 if it was not fitted.
    pub fn standard_error(&self, unknown: Unknown) -> f64 {
        let index = self.index(unknown);
        index.map_or(0.0, |i| self.covariance[(i, i)].sqrt())
    }

    /// Correlation of two fitted parameters; none if one was not fitted.
    pub fn correlation(&self, a: Unknown, b: Unknown) -> Option<f64> {
        let (a, b) = (self.index(a)?, self.index(b)?);
        let variances = self.covariance[(a, a)] * self.covariance[(b, b)];
        Some(self.covariance[(a, b)] / variances.sqrt())
    }

    fn index(&self, unknown: Unknown) -> Option<usize> {
        self.unknowns.iter().position(|u| *u == unknown)
    }

    /// Sum of squares of all residuals in rad².
    pub fn sum_of_squares(&self) -> f64 {
        let residuals = self.residuals_rad.iter().flatten().flatten();
        residuals.map(|residual| residual * residual).sum()
    }

    /// Number of residuals.
    pub fn count(&self) -> usize {
        self.residuals_rad.iter().flatten().flatten().count()
    }

    /// Message that names parameters of which only a combination is identifiable, with a
    /// remedy; none if all are identifiable.
    pub fn unidentifiable(&self) -> Option<String> {
        if self.condition < SINGULAR_CONDITION {
            return None;
        }
        let shares = self.unknowns.iter().zip(&self.weakest_share);
        let combined = shares.filter(|(_, share)| **share > 0.5);
        let names: Vec<&str> = combined.map(|(unknown, _)| unknown.name()).collect();
        let (last, others) = names.split_last()?;
        let remedy = if names.contains(&Unknown::Gravity.name()) {
            "fix the weight, measured with a scale and a ruler"
        } else {
            "add a motion in the other direction, or without motor torque"
        };
        Some(format!(
            "{} and {last} are not separately identifiable; {remedy}",
            others.join(", ")
        ))
    }
}

/// Fits the unknowns and the unknown initial states, starting at `guess`.
///
/// # Errors
/// See [`FitError`].
pub fn fit(
    sampled: &[SampledExperiment],
    unknowns: &[Unknown],
    guess: &JointParameters,
) -> Result<Fit, FitError> {
    let mut problem = Problem::new(sampled, unknowns, guess);
    let samples = sampled.iter().map(SampledExperiment::count).sum();
    let columns = problem.x.len();
    if samples <= columns {
        return Err(FitError::TooFewSamples {
            samples,
            unknowns: columns,
        });
    }
    if let Some(kind) = problem.sticks {
        return Err(FitError::Sticks { kind });
    }
    let end = minimise(&mut problem, Limits::default());
    let finite = problem.x.iter().all(|x| x.is_finite());
    if end == End::NotFinite || !finite || problem.sticks.is_some() {
        return Err(FitError::NotConverged);
    }
    Ok(Fit::from_problem(&problem))
}
