//! Controllers designed for the linear loop, without a board.

use armbridge_analysis::design;
use armbridge_client::{params, refusal_text};
use armbridge_link::message::{Controller, Gains, Settings};
use numpy::{Complex64, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{to_python, value_error};
use crate::settings;

/// A design: gain, poles and margins of the loop about upright that the board closes.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Design {
    settings: Settings,
    design: design::Design,
}

impl Design {
    fn new(settings: &Settings) -> PyResult<Self> {
        let design = design::Design::from_setup(&settings.setup).map_err(|why| {
            value_error(format!(
                "the board would refuse this set-up: {}",
                refusal_text::in_words(why)
            ))
        })?;
        Ok(Self {
            settings: *settings,
            design,
        })
    }
}

#[pymethods]
impl Design {
    /// Gain from state to torque, of shape (2, 4), in N m/rad and N m s/rad.
    #[getter]
    fn gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows: Vec<Vec<f64>> = self.design.gain.iter().map(|row| row.to_vec()).collect();
        PyArray2::from_vec2(py, &rows).map_err(value_error)
    }

    /// Poles in z of the controller, the estimator and the actuators, of shape (n,).
    #[getter]
    fn poles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex64>> {
        let poles = self.design.poles.all().flat_map(|(_, pole)| {
            let first = Complex64::new(pole.re, pole.im);
            let second = (pole.im != 0.0).then(|| first.conj());
            std::iter::once(first).chain(second)
        });
        PyArray1::from_iter(py, poles)
    }

    /// Margins of the loop, by name.
    #[getter]
    fn margins(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        to_python(py, &self.design.margins)
    }

    /// Whether the loop is stable.
    #[getter]
    fn is_stable(&self) -> bool {
        self.design.is_stable
    }

    /// Parameters for `Board.set`.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut pairs = params::pairs(&self.settings);
        pairs.retain(|(it, _)| ["setup", "controller", "estimator"].contains(&it.group()));
        settings::pairs_to_dict(py, &pairs)
    }

    fn __repr__(&self) -> String {
        let disc = self.design.margins.disc.alpha;
        let stable = if self.design.is_stable {
            "stable"
        } else {
            "unstable"
        };
        format!("<Design, {stable}, disc margin {disc:.3}>")
    }
}

/// Parameters of a design: the board's defaults, or those given.
fn base(given: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    match given {
        Some(given) => settings::changed(&Settings::default(), given),
        None => Ok(Settings::default()),
    }
}

/// A controller of this kind, with these parameters.
fn of_kind(
    py: Python<'_>,
    kind: &str,
    parameters: [(&str, &Bound<'_, PyAny>); 2],
    given: Option<&Bound<'_, PyDict>>,
) -> PyResult<Design> {
    let chosen = PyDict::new(py);
    chosen.set_item("controller.kind", kind)?;
    for (name, value) in parameters {
        chosen.set_item(name, value)?;
    }
    Design::new(&settings::changed(&base(given)?, &chosen)?)
}

/// The regulator of least cost: `q` weighs both angles and both speeds, `r` both torques.
/// `settings` are parameters by name, such as `Board.settings`; the board's defaults without.
#[pyfunction]
#[pyo3(signature = (q, r, *, settings = None))]
pub(crate) fn lqr(
    py: Python<'_>,
    q: &Bound<'_, PyAny>,
    r: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Design> {
    let parameters = [("controller.q", q), ("controller.r", r)];
    of_kind(py, "lqr", parameters, settings)
}

/// Computed torque: natural frequencies in rad/s and damping ratios of the errors of both joints.
#[pyfunction]
#[pyo3(signature = (natural, damping, *, settings = None))]
pub(crate) fn computed_torque(
    py: Python<'_>,
    natural: &Bound<'_, PyAny>,
    damping: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Design> {
    let parameters = [
        ("controller.natural_rad_s", natural),
        ("controller.damping", damping),
    ];
    of_kind(py, "computed-torque", parameters, settings)
}

/// State feedback whose loop has these poles in z, of shape (2, 2): two for each joint, real or
/// conjugate.
#[pyfunction]
#[pyo3(signature = (poles, *, settings = None))]
pub(crate) fn place(
    poles: [[Complex64; 2]; 2],
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Design> {
    let mut settings = base(settings)?;
    let pairs = poles.map(|pair| design::pole_pair(pair.map(|pole| (pole.re, pole.im))));
    let [Some(first), Some(second)] = pairs else {
        return Err(value_error(
            "expected two poles for each joint inside the unit circle, real or conjugate, as \
             [[0.98, 0.97], [0.98+0.01j, 0.98-0.01j]]",
        ));
    };
    let gain = design::place(&settings.setup, [first, second]).map_err(value_error)?;
    settings.setup.controller = Controller::StateFeedback(Gains::Given(gain));
    Design::new(&settings)
}
