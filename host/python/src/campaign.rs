//! Fault campaigns: cases by their seeds, and their results.

use armbridge_sim::fault_campaign::{self, Activity, Campaign as Merged, Case, Outcome};
use pyo3::prelude::*;

use crate::errors::{to_python, value_error};
use crate::interrupt;

/// Runs the cases of these seeds, and returns them as JSON; a pure function of its arguments.
#[pyfunction]
#[pyo3(signature = (seeds, *, activity = None, park = false))]
pub(crate) fn campaign_part(
    py: Python<'_>,
    seeds: Vec<u64>,
    activity: Option<&str>,
    park: bool,
) -> PyResult<String> {
    let activity: Option<Activity> = activity.map(str::parse).transpose().map_err(value_error)?;
    let outcomes = interrupt::run(py, || {
        let cases = seeds.iter().map(|seed| {
            let case = Case::with_activity(*seed, activity);
            if park { case.with_pose() } else { case }
        });
        let wanted = cases.take_while(|_| !interrupt::is_interrupted());
        wanted.map(|case| fault_campaign::run(&case)).collect()
    })?;
    merged(outcomes)?.to_json().map_err(value_error)
}

/// A fault campaign.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Campaign(Merged);

fn merged(outcomes: Vec<Outcome>) -> PyResult<Merged> {
    Merged::new(outcomes).map_err(value_error)
}

#[pymethods]
impl Campaign {
    /// Joins parts, each as JSON of some seeds.
    #[new]
    fn new(parts: Vec<String>) -> PyResult<Self> {
        let cases: Result<Vec<_>, _> = parts.iter().map(|part| Merged::cases_of(part)).collect();
        merged(cases.map_err(value_error)?.concat()).map(Self)
    }

    /// Whether all requirements are met.
    #[getter]
    fn holds(&self) -> bool {
        self.0.report.holds()
    }

    /// Results by kind of fault, activity and set-up, and the failures.
    #[getter]
    fn report(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        to_python(py, &self.0.report)
    }

    /// Cases in the order of their seeds, a dictionary each.
    #[getter]
    fn cases(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        to_python(py, &self.0.outcomes)
    }

    /// What `armbridge fault-campaign --json` prints of the same seeds, to the byte.
    fn to_json(&self) -> PyResult<String> {
        self.0.to_json().map_err(value_error)
    }

    fn __len__(&self) -> usize {
        self.0.outcomes.len()
    }

    fn __str__(&self) -> String {
        fault_campaign::table(&self.0.report)
    }

    fn __repr__(&self) -> String {
        let (cases, failures) = (self.0.outcomes.len(), self.0.report.failures.len());
        format!("<Campaign of {cases} cases, {failures} failed>")
    }
}
