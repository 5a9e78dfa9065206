//! Scenarios on the simulated board, as fast as the machine computes them.

use std::path::PathBuf;

use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_analysis::sweep::run_once;
use armbridge_client::params;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::pair;
use crate::errors::{log_error, to_python, value_error};
use crate::plant::PlantArgument;
use crate::{interrupt, settings};

/// Runs a scenario, a file or one that ships, on a simulated board and arm, and returns its
/// figures. The same arguments give the same run, to the bit. `settings` are parameters of the
/// board by name, `initial` angles in rad; `log` is the path of a log to be written.
#[pyfunction]
#[pyo3(signature = (scenario = "demo", *, settings = None, plant = None, friction = None, initial = None, seed = None, duration = None, log = None))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn bench(
    py: Python<'_>,
    scenario: &str,
    settings: Option<&Bound<'_, PyDict>>,
    plant: Option<PlantArgument>,
    friction: Option<bool>,
    initial: Option<&Bound<'_, PyAny>>,
    seed: Option<u64>,
    duration: Option<f64>,
    log: Option<PathBuf>,
) -> PyResult<Py<PyAny>> {
    let initial = initial.map(|q| pair(q, "angles in rad")).transpose()?;
    let plant = plant.map(PlantArgument::file).transpose()?;
    let set = settings.map_or_else(|| Ok(Vec::new()), settings::pairs)?;
    if let Some((unknown, _)) = set.iter().find(|(key, _)| params::find(key).is_none()) {
        return Err(value_error(params::unknown(unknown)));
    }
    let overrides = Overrides {
        set,
        plant,
        friction,
        initial_rad: initial,
        seed,
        duration_s: duration,
        ..Overrides::default()
    };
    let scenario = Scenario::load(scenario, &overrides).map_err(value_error)?;
    let run = || run_once(&scenario, log.as_deref(), interrupt::is_interrupted);
    let figures = interrupt::run(py, run)?.map_err(log_error)?;
    to_python(py, &figures)
}
