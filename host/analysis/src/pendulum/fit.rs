//! Fit of a form of friction to recordings: the parameters with the smallest error.
//!
//! The error is the mean absolute difference of simulated and measured angles over all samples,
//! in degrees. It has many local minima, where some recording sticks or slips at another moment;
//! so every fit is the better of several searches with different seeds.

use std::convert::Infallible;

use nalgebra::DVector;
use serde::Serialize;

use super::covariance_adaptation::{Search, minimise};
use super::model::simulate;
use super::parameters::{FrictionForm, Parameters};
use super::recording::Recording;
use crate::monte_carlo::batch;

/// Magnitude of a coordinate beyond which the cost grows: a parameter that may be zero stays at
/// a fiftieth of its initial value, where it has no effect.
const COORDINATE_FAR: f64 = 4.0;
/// Growth of the cost in degrees.
const FAR_COST_DEG: f64 = 1e-3;

/// Parameters of a form of friction, fitted to recordings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The form.
    pub form: FrictionForm,
    /// Its parameters.
    pub parameters: Parameters,
    /// Error on the recordings of the fit in degrees.
    pub error_deg: f64,
}

/// A fit to be made.
pub(super) struct Task<'a> {
    /// Form of friction.
    pub(super) form: FrictionForm,
    /// Recordings to fit to.
    pub(super) recordings: Vec<&'a Recording>,
    /// Parameters to begin at; without, those of small servos.
    pub(super) start: Option<Parameters>,
    /// Extent of the search.
    pub(super) search: Search,
}

/// The searches were ended before all tasks were done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Interrupted;

impl Task<'_> {
    fn fit(&self) -> Fit {
        let quantities = self.form.quantities();
        let start = match &self.start {
            Some(parameters) => parameters.coordinates(&quantities),
            None => DVector::zeros(quantities.len()),
        };
        let cost = |coordinates: &DVector<f64>| {
            let far = |coordinate: &f64| (coordinate.abs() - COORDINATE_FAR).max(0.0).powi(2);
            let far: f64 = coordinates.iter().map(far).sum();
            let parameters = Parameters::at(&quantities, coordinates);
            error_deg(&self.recordings, &parameters) + FAR_COST_DEG * far
        };
        let (coordinates, _) = minimise(cost, &start, &self.search);
        let parameters = Parameters::at(&quantities, &coordinates);
        Fit {
            form: self.form,
            parameters,
            error_deg: error_deg(&self.recordings, &parameters),
        }
    }
}

/// The fits of tasks, in their order, on all processors; `done` receives the number of finished
/// ones after each.
pub(super) fn fit_all(
    tasks: &[Task<'_>],
    done: impl FnMut(usize),
) -> Result<Vec<Fit>, Interrupted> {
    let fit = |task: &Task<'_>| Ok::<Fit, Infallible>(task.fit());
    let fits = batch::for_each(tasks, fit, done).finished;
    if fits.len() == tasks.len() {
        Ok(fits)
    } else {
        Err(Interrupted)
    }
}

/// The fit with the smallest error.
pub(super) fn best(fits: &[Fit]) -> Option<Fit> {
    let by_error = |a: &&Fit, b: &&Fit| a.error_deg.total_cmp(&b.error_deg);
    fits.iter().min_by(by_error).copied()
}

/// Mean absolute error of the simulated angle over all samples of recordings, in degrees.
pub fn error_deg(recordings: &[&Recording], parameters: &Parameters) -> f64 {
    let mut sum_rad = 0.0;
    let mut samples = 0;
    for recording in recordings {
        let angles_rad = simulate(recording, parameters);
        let pairs = angles_rad.iter().zip(&recording.samples);
        sum_rad += pairs
            .map(|(angle_rad, sample)| (angle_rad - sample.angle_rad).abs())
            .sum::<f64>();
        samples += recording.samples.len();
    }
    (sum_rad / samples as f64).to_degrees()
}
