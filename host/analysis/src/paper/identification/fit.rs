//! The numbers with whose motion the samples agree best, and how well they are known.
//!
//! Levenberg and Marquardt on the angles, with exact derivatives, bounded by nothing. The
//! error of each sample is taken for white noise whose size the residuals tell: that is
//! what the standard errors mean, and they mean nothing where the model is of the wrong
//! form, see [`Form`](super::Form).
//!
//! A start of the search at which friction holds the arm would be its end: nothing moves,
//! so nothing depends on any number. Such a start is refused by name.

use levenberg_marquardt::LevenbergMarquardt;
use nalgebra::{DMatrix, DVector};

use super::numbers::{Numbers, Unknown};
use super::problem::Problem;
use super::sampled::{Kind, Sampled};

/// Condition number beyond which a combination of numbers is not seen at all: with exact
/// derivatives, what is left of one that has no effect is rounding.
const BLIND: f64 = 1e9;

/// What was found.
#[derive(Clone, Debug)]
pub struct Fit {
    /// All numbers, sought or not.
    pub numbers: Numbers,
    /// Those that were sought.
    pub unknowns: Vec<Unknown>,
    /// How each experiment begins: angle in rad, speed in rad/s.
    pub starts: Vec<[f64; 2]>,
    /// Covariance of the unknowns, and after them of the starts that were found.
    pub covariance: DMatrix<f64>,
    /// Largest over smallest effect that changes of the unknowns by shares of their size
    /// have on the samples.
    pub condition: f64,
    /// Of each number's variance, the share that is due to the change with the least
    /// effect.
    pub(super) faintest: Vec<f64>,
    /// Root of the mean square of all residuals, in rad.
    pub rms_rad: f64,
    /// Measured less computed in rad, for each experiment; none where a sample is missing.
    pub residuals_rad: Vec<Vec<Option<f64>>>,
}

/// Why nothing was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Fewer samples than needed.
    #[error("{samples} samples are too few for {unknowns} unknown numbers")]
    TooFew {
        /// That there are.
        samples: usize,
        /// Starts that are not known included.
        unknowns: usize,
    },
    /// With the numbers to begin with, an experiment does not move.
    #[error(
        "with the dry friction to begin with, the arm sticks in the {}: nothing would depend on \
         any number; begin with less",
        kind.name()
    )]
    Sticks {
        /// Which.
        kind: Kind,
    },
    /// The search did not come to an end.
    #[error("the search for the numbers came to no end: do these samples show a moving arm?")]
    NoEnd,
}

impl Fit {
    /// What the search has come to.
    fn of(problem: &Problem) -> Self {
        let numbers = problem.numbers();
        let starts = problem
            .starts()
            .into_iter()
            .map(|(start, _)| start)
            .collect();
        let (rows, columns) = problem.jacobian.shape();
        // Changes by shares of what each number is.
        let size = DVector::from_fn(columns, |j, _| match problem.unknowns.get(j) {
            Some(unknown) => problem.at[j].abs().max(unknown.much()),
            None => problem.at[j].abs().max(0.05),
        });
        let scaled = DMatrix::from_fn(rows, columns, |i, j| problem.jacobian[(i, j)] * size[j]);
        let svd = scaled.svd(false, true);
        let values = &svd.singular_values;
        let largest = values.max();
        let smallest = values.min();
        let turned = svd
            .v_t
            .unwrap_or_else(|| DMatrix::identity(columns, columns));
        let squares = problem.residuals.norm_squared();
        let variance = squares / (rows - columns) as f64;
        let weight = values.map(|value| variance / value.max(largest * 1e-15).powi(2));
        let least = values.imin();
        let faintest = (0..columns).map(|j| {
            let parts = (0..columns).map(|k| turned[(k, j)].powi(2) * weight[k]);
            turned[(least, j)].powi(2) * weight[least] / parts.sum::<f64>()
        });
        let faintest = faintest.collect();
        let shares = turned.transpose() * DMatrix::from_diagonal(&weight) * &turned;
        let covariance =
            DMatrix::from_fn(columns, columns, |i, j| shares[(i, j)] * size[i] * size[j]);
        let mut residuals = problem.residuals.iter().copied();
        let residuals_rad = problem.sampled.iter().map(|sampled| {
            let seen = sampled.angles_rad.iter();
            seen.map(|angle| angle.and_then(|_| residuals.next()))
                .collect()
        });
        Self {
            numbers,
            unknowns: problem.unknowns.to_vec(),
            starts,
            residuals_rad: residuals_rad.collect(),
            covariance,
            condition: largest / smallest,
            faintest,
            rms_rad: (squares / rows as f64).sqrt(),
        }
    }

    /// Standard error of a number; 0 if it was not sought.
    pub fn error(&self, unknown: Unknown) -> f64 {
        let at = self.unknowns.iter().position(|u| *u == unknown);
        at.map_or(0.0, |i| self.covariance[(i, i)].sqrt())
    }

    /// Correlation of two numbers that were sought; none of others.
    pub fn correlation(&self, a: Unknown, b: Unknown) -> Option<f64> {
        let at = |unknown| self.unknowns.iter().position(|u| *u == unknown);
        let (a, b) = (at(a)?, at(b)?);
        let variances = self.covariance[(a, a)] * self.covariance[(b, b)];
        Some(self.covariance[(a, b)] / variances.sqrt())
    }

    /// Sum of squares of all residuals in rad².
    pub fn squares(&self) -> f64 {
        let all = self.residuals_rad.iter().flatten().flatten();
        all.map(|residual| residual * residual).sum()
    }

    /// Samples that were compared.
    pub fn count(&self) -> usize {
        self.residuals_rad.iter().flatten().flatten().count()
    }

    /// Numbers of which the samples tell nothing but a combination, and what would help;
    /// none if all are identifiable.
    pub fn blind_spot(&self) -> Option<String> {
        if self.condition < BLIND {
            return None;
        }
        let shares = self.unknowns.iter().zip(&self.faintest);
        let moved = shares.filter(|(_, share)| **share > 0.5);
        let names: Vec<&str> = moved.map(|(unknown, _)| unknown.name()).collect();
        let (last, others) = names.split_last()?;
        let help = if names.contains(&Unknown::Gravity.name()) {
            "keep the weight, which a scale and a ruler tell"
        } else {
            "only a motion the other way, or without the motor, tells them apart"
        };
        Some(format!(
            "{} and {last} cannot be told apart; {help}",
            others.join(", ")
        ))
    }
}

/// Seeks these numbers, and the starts that are not known, beginning at `guess`.
///
/// # Errors
/// See [`FitError`].
pub fn fit(sampled: &[Sampled], unknowns: &[Unknown], guess: &Numbers) -> Result<Fit, FitError> {
    let problem = Problem::new(sampled, unknowns, guess);
    let samples = sampled.iter().map(Sampled::count).sum();
    let columns = problem.at.len();
    if samples <= columns {
        return Err(FitError::TooFew {
            samples,
            unknowns: columns,
        });
    }
    if let Some(kind) = problem.sticks {
        return Err(FitError::Sticks { kind });
    }
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    // At the bottom, rounding may be all that is left to gain.
    let ended = report.termination.was_successful()
        || matches!(
            report.termination,
            levenberg_marquardt::TerminationReason::NoImprovementPossible(_)
                | levenberg_marquardt::TerminationReason::LostPatience
        );
    let finite = problem.at.iter().all(|x| x.is_finite());
    if !(ended && finite) || problem.sticks.is_some() {
        return Err(FitError::NoEnd);
    }
    Ok(Fit::of(&problem))
}
