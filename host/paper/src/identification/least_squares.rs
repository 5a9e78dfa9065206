//! Least-squares problem: all residuals and their derivatives.

use core::ops::Range;

use nalgebra::{DMatrix, DVector};
use num_dual::DualSVec64;

use super::joint_parameters::{COUNT, JointParameters, Unknown};
use super::motion::simulate;
use super::sampled_experiment::{ExperimentKind, SampledExperiment};
use armbridge_analysis::levenberg_marquardt::LeastSquares;

/// Components of an initial state: angle and speed.
const STATES: usize = 2;
/// Derivatives of a motion: with respect to the parameters and the initial state.
const LANES: usize = COUNT + STATES;
/// Residual in rad of a motion that diverges: larger than any real one.
const DIVERGED_RAD: f64 = 1e3;

/// The problem at the current estimate.
pub(super) struct Problem<'a> {
    pub(super) sampled: &'a [SampledExperiment],
    pub(super) unknowns: &'a [Unknown],
    guess: JointParameters,
    /// Current estimate: the unknowns, then the unknown initial states.
    pub(super) x: DVector<f64>,
    pub(super) residuals: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    /// The first experiment in which the arm does not move.
    pub(super) sticks: Option<ExperimentKind>,
}

impl<'a> Problem<'a> {
    /// Problem at the guess.
    pub(super) fn new(
        sampled: &'a [SampledExperiment],
        unknowns: &'a [Unknown],
        guess: &JointParameters,
    ) -> Self {
        let parameters = unknowns.iter().map(|unknown| guess.get(*unknown));
        let starts = sampled.iter().flat_map(|sampled| {
            let start = [sampled.start_rad, 0.0];
            start.into_iter().take(sampled.start.unknowns())
        });
        let x: Vec<f64> = parameters.chain(starts).collect();
        let rows = sampled.iter().map(SampledExperiment::count).sum();
        let mut problem = Self {
            sampled,
            unknowns,
            guess: *guess,
            residuals: DVector::zeros(rows),
            jacobian: DMatrix::zeros(rows, x.len()),
            x: x.into(),
            sticks: None,
        };
        problem.evaluate();
        problem
    }

    /// Parameters at the current estimate.
    pub(super) fn parameters(&self) -> JointParameters {
        let estimates = self.unknowns.iter().zip(self.x.iter());
        estimates.fold(self.guess, |parameters, (unknown, x)| {
            parameters.with(*unknown, *x)
        })
    }

    /// Initial state of each experiment, and the columns of its estimated components.
    pub(super) fn starts(&self) -> Vec<([f64; STATES], Range<usize>)> {
        let mut next = self.unknowns.len();
        let start = |sampled: &SampledExperiment| {
            let columns = next..next + sampled.start.unknowns();
            next = columns.end;
            let mut start = [sampled.start_rad, 0.0];
            for (number, column) in start.iter_mut().zip(columns.clone()) {
                *number = self.x[column];
            }
            (start, columns)
        };
        self.sampled.iter().map(start).collect()
    }

    /// Computes all residuals and their derivatives.
    fn evaluate(&mut self) {
        type Dual = DualSVec64<LANES>;
        let values = self.parameters().to_array();
        let lanes = core::array::from_fn(|i| Dual::from_re(values[i]).derivative(i));
        let parameters = JointParameters::from_array(lanes);
        self.sticks = None;
        let mut row = 0;
        for (sampled, (start, columns)) in self.sampled.iter().zip(self.starts()) {
            let lane = |i: usize| Dual::from_re(start[i]).derivative(COUNT + i);
            let start = core::array::from_fn(lane);
            let is_pushed = sampled.kind == ExperimentKind::ConstantInput;
            let samples = sampled.angles_rad.len();
            let model = simulate(&parameters, is_pushed, start, sampled.period_s, samples);
            if model.sticks && self.sticks.is_none() {
                self.sticks = Some(sampled.kind);
            }
            for (measured, angle) in sampled.angles_rad.iter().zip(&model.rad) {
                let Some(measured) = measured else { continue };
                let residual = measured - angle.re;
                self.residuals[row] = if residual.is_finite() {
                    residual
                } else {
                    DIVERGED_RAD
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

impl LeastSquares for Problem<'_> {
    fn coordinates(&self) -> DVector<f64> {
        self.x.clone()
    }

    fn set_coordinates(&mut self, x: &DVector<f64>) {
        if *x != self.x {
            self.x.copy_from(x);
            self.evaluate();
        }
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.jacobian.clone())
    }
}
