//! The numbers with whose motion the samples agree best, and how well they are known.
//!
//! Levenberg and Marquardt on the angles, with exact derivatives, bounded by nothing. The
//! error of each sample is taken for white noise whose size the residuals tell: that is
//! what the standard errors mean, and they mean nothing where the model is of the wrong
//! form, see [`Form`](super::Form).
//!
//! A start of the search at which friction holds the arm would be its end: nothing moves,
//! so nothing depends on any number. Such a start is refused by name.

use core::ops::Range;

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector};
use nalgebra_lm as lm;
use num_dual::DualSVec64;

use super::motion::angles;
use super::numbers::{COUNT, Numbers, Unknown};
use super::sampled::{Kind, Sampled};

/// Derivatives that a motion carries: the numbers, and how it begins.
const LANES: usize = COUNT + STARTS;
/// Numbers of a start: angle and speed.
const STARTS: usize = 2;
/// Error in rad of a motion that runs away: no real one is as large.
const AWAY_RAD: f64 = 1e3;
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
    faintest: Vec<f64>,
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
    /// none if all are told.
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
    Ok(problem.found())
}

struct Problem<'a> {
    sampled: &'a [Sampled],
    unknowns: &'a [Unknown],
    guess: Numbers,
    /// Unknowns, and starts that are not known.
    at: lm::DVector<f64>,
    residuals: lm::DVector<f64>,
    jacobian: lm::DMatrix<f64>,
    /// The first experiment that does not move.
    sticks: Option<Kind>,
}

impl<'a> Problem<'a> {
    fn new(sampled: &'a [Sampled], unknowns: &'a [Unknown], guess: &Numbers) -> Self {
        let known = unknowns.iter().map(|unknown| guess.get(*unknown));
        let unknown = sampled.iter().flat_map(|sampled| {
            let start = [sampled.start_rad, 0.0];
            start.into_iter().take(sampled.start.unknowns())
        });
        let at: Vec<f64> = known.chain(unknown).collect();
        let rows = sampled.iter().map(Sampled::count).sum();
        let mut problem = Self {
            sampled,
            unknowns,
            guess: *guess,
            residuals: lm::DVector::zeros(rows),
            jacobian: lm::DMatrix::zeros(rows, at.len()),
            at: at.into(),
            sticks: None,
        };
        problem.look();
        problem
    }

    fn numbers(&self) -> Numbers {
        let found = self.unknowns.iter().zip(self.at.iter());
        found.fold(self.guess, |numbers, (unknown, x)| {
            numbers.with(*unknown, *x)
        })
    }

    /// Of each experiment: how it begins, and the columns of what is sought of that.
    fn starts(&self) -> Vec<([f64; STARTS], Range<usize>)> {
        let mut next = self.unknowns.len();
        let start = |sampled: &Sampled| {
            let columns = next..next + sampled.start.unknowns();
            next = columns.end;
            let mut start = [sampled.start_rad, 0.0];
            for (number, column) in start.iter_mut().zip(columns.clone()) {
                *number = self.at[column];
            }
            (start, columns)
        };
        self.sampled.iter().map(start).collect()
    }

    /// Computes all motions, with their derivatives.
    fn look(&mut self) {
        type Dual = DualSVec64<LANES>;
        let numbers = self.numbers().to_array();
        let lanes = core::array::from_fn(|i| Dual::from_re(numbers[i]).derivative(i));
        let numbers = Numbers::from_array(lanes);
        self.sticks = None;
        let mut row = 0;
        for (sampled, (start, columns)) in self.sampled.iter().zip(self.starts()) {
            let lane = |i: usize| Dual::from_re(start[i]).derivative(COUNT + i);
            let start = core::array::from_fn(lane);
            let is_pushed = sampled.kind == Kind::ConstantInput;
            let samples = sampled.angles_rad.len();
            let model = angles(&numbers, is_pushed, start, sampled.period_s, samples);
            if model.sticks && self.sticks.is_none() {
                self.sticks = Some(sampled.kind);
            }
            for (measured, angle) in sampled.angles_rad.iter().zip(&model.rad) {
                let Some(measured) = measured else { continue };
                let residual = measured - angle.re;
                self.residuals[row] = if residual.is_finite() {
                    residual
                } else {
                    AWAY_RAD
                };
                let slope = |lane: usize| {
                    let slope = angle.eps.0.map_or(0.0, |eps| -eps[lane]);
                    if slope.is_finite() { slope } else { 0.0 }
                };
                for (j, unknown) in self.unknowns.iter().enumerate() {
                    self.jacobian[(row, j)] = slope(*unknown as usize);
                }
                for (i, column) in columns.clone().enumerate() {
                    self.jacobian[(row, column)] = slope(COUNT + i);
                }
                row += 1;
            }
        }
    }

    fn found(self) -> Fit {
        let numbers = self.numbers();
        let starts = self.starts().into_iter().map(|(start, _)| start).collect();
        let (rows, columns) = self.jacobian.shape();
        // Changes by shares of what each number is.
        let size = DVector::from_fn(columns, |j, _| match self.unknowns.get(j) {
            Some(unknown) => self.at[j].abs().max(unknown.much()),
            None => self.at[j].abs().max(0.05),
        });
        let scaled = DMatrix::from_fn(rows, columns, |i, j| self.jacobian[(i, j)] * size[j]);
        let svd = scaled.svd(false, true);
        let values = &svd.singular_values;
        let largest = values.max();
        let smallest = values.min();
        let turned = svd
            .v_t
            .unwrap_or_else(|| DMatrix::identity(columns, columns));
        let squares = self.residuals.norm_squared();
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
        let mut residuals = self.residuals.iter().copied();
        let residuals_rad = self.sampled.iter().map(|sampled| {
            let seen = sampled.angles_rad.iter();
            seen.map(|angle| angle.and_then(|_| residuals.next()))
                .collect()
        });
        Fit {
            numbers,
            unknowns: self.unknowns.to_vec(),
            starts,
            residuals_rad: residuals_rad.collect(),
            covariance,
            condition: largest / smallest,
            faintest,
            rms_rad: (squares / rows as f64).sqrt(),
        }
    }
}

impl LeastSquaresProblem<f64, lm::Dyn, lm::Dyn> for Problem<'_> {
    type ResidualStorage = lm::storage::Owned<f64, lm::Dyn>;
    type JacobianStorage = lm::storage::Owned<f64, lm::Dyn, lm::Dyn>;
    type ParameterStorage = lm::storage::Owned<f64, lm::Dyn>;

    fn set_params(&mut self, x: &lm::DVector<f64>) {
        if *x != self.at {
            self.at.copy_from(x);
            self.look();
        }
    }

    fn params(&self) -> lm::DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<lm::DVector<f64>> {
        Some(self.residuals.clone())
    }

    fn jacobian(&self) -> Option<lm::DMatrix<f64>> {
        Some(self.jacobian.clone())
    }
}
