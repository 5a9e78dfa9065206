//! Arms identified from logs, or by experiments on a board.

use std::path::PathBuf;

use armbridge_analysis::identify::{ArmFit, ArmFitError, FitData};
use armbridge_log::log_path;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{IdentifyError, log_error, to_python, value_error};
use crate::plant::Plant;
use crate::{interrupt, settings};

/// An arm identified from its motion.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Fit(ArmFit);

/// Relative standard error of a known weight.
#[derive(Clone, Copy)]
pub(crate) struct WeightError(f64);

impl WeightError {
    pub(crate) fn new(weighed: f64) -> PyResult<Self> {
        if (1e-4..=1.0).contains(&weighed) {
            return Ok(Self(weighed));
        }
        Err(value_error(format!(
            "expected a relative error from 0.0001 to 1 for `weighed`, got {weighed}"
        )))
    }
}

impl Fit {
    /// Fits the arm to data.
    pub(crate) fn new(py: Python<'_>, data: FitData, weighed: WeightError) -> PyResult<Self> {
        let fit = interrupt::run(py, || ArmFit::new(data, weighed.0))?;
        fit.map(Self)
            .map_err(|diagnosis| IdentifyError::new_err(diagnosis.to_string()))
    }
}

#[pymethods]
impl Fit {
    /// Parameters of the arm for `Board.set`, and for the keys of a scenario.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let pairs = self.0.parameters().map_err(value_error)?;
        settings::pairs_to_dict(py, &pairs)
    }

    /// Parameters of a board with the identified arm: its own, and a gain for it where it has one
    /// that was given instead of designed.
    fn adopted_by<'py>(
        &self,
        py: Python<'py>,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let before = settings::changed(&self.0.before, settings)?;
        let (after, _) = self.0.adopted_by(&before).map_err(value_error)?;
        settings::to_dict(py, &after)
    }

    /// Estimates as a list of dictionaries: joint, name, unit, value, half width of the 95 %
    /// interval.
    #[getter]
    fn estimates(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        to_python(py, &self.0.report.estimates)
    }

    /// So many virtual arms, drawn from the distribution of the estimates; a pure function of the fit
    /// and its arguments.
    #[pyo3(signature = (count, seed = 0))]
    fn plants(&self, py: Python<'_>, count: usize, seed: u64) -> PyResult<Vec<Plant>> {
        let arms = py.detach(|| self.0.plausible_arms(count, seed));
        let arms = arms.map_err(value_error)?;
        Ok(arms.into_iter().map(Plant).collect())
    }

    /// Reasons, a sentence each, for which the estimates are too uncertain to control an arm by;
    /// empty if they are certain enough.
    #[getter]
    fn uncertain(&self) -> Vec<String> {
        let reasons = self.0.report.too_uncertain();
        reasons.iter().map(ToString::to_string).collect()
    }

    fn __str__(&self) -> String {
        self.0.report.table() + &self.0.checks.text()
    }

    fn __repr__(&self) -> String {
        let report = &self.0.report;
        format!(
            "<Fit to {} windows, {:.1} s of sliding>",
            report.windows, report.sliding_s
        )
    }
}

/// Identifies an arm from logs, of one board each the same; a folder means the log in it. `weighed`
/// is the relative standard error of the arm's known weight.
#[pyfunction]
#[pyo3(signature = (*logs, weighed = 0.01))]
pub(crate) fn identify(py: Python<'_>, logs: Vec<PathBuf>, weighed: f64) -> PyResult<Fit> {
    let weighed = WeightError::new(weighed)?;
    let found = logs
        .iter()
        .map(|log| log_path::find(Some(log), "".as_ref()));
    let found: Result<Vec<PathBuf>, _> = found.collect();
    let found = found.map_err(log_error)?;
    let data = py.detach(|| FitData::load(&found));
    let data = data.map_err(|error| match error {
        ArmFitError::Diagnosis(why) => IdentifyError::new_err(why.to_string()),
        error => log_error(error),
    })?;
    Fit::new(py, data, weighed)
}
