//! Least squares as the search sees it: all residuals and their derivatives.

use core::ops::Range;

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra_lm as lm;
use num_dual::DualSVec64;

use super::motion::angles;
use super::numbers::{COUNT, Numbers, Unknown};
use super::sampled::{Kind, Sampled};

/// Numbers of a start: angle and speed.
const STARTS: usize = 2;
/// Derivatives that a motion carries: the numbers, and how it begins.
const LANES: usize = COUNT + STARTS;
/// Error in rad of a motion that runs away: no real one is as large.
const AWAY_RAD: f64 = 1e3;

/// The search, wherever it is.
pub(super) struct Problem<'a> {
    pub(super) sampled: &'a [Sampled],
    pub(super) unknowns: &'a [Unknown],
    guess: Numbers,
    /// Unknowns, and starts that are not known.
    pub(super) at: lm::DVector<f64>,
    pub(super) residuals: lm::DVector<f64>,
    pub(super) jacobian: lm::DMatrix<f64>,
    /// The first experiment that does not move.
    pub(super) sticks: Option<Kind>,
}

impl<'a> Problem<'a> {
    /// At its beginning.
    pub(super) fn new(sampled: &'a [Sampled], unknowns: &'a [Unknown], guess: &Numbers) -> Self {
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

    pub(super) fn numbers(&self) -> Numbers {
        let found = self.unknowns.iter().zip(self.at.iter());
        found.fold(self.guess, |numbers, (unknown, x)| {
            numbers.with(*unknown, *x)
        })
    }

    /// Of each experiment: how it begins, and the columns of what is sought of that.
    pub(super) fn starts(&self) -> Vec<([f64; STARTS], Range<usize>)> {
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
