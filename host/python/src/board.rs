//! A board: commands, and the contexts in which it is armed.

use std::path::PathBuf;
use std::sync::Arc;

use armbridge_analysis::identify::FitData;
use armbridge_analysis::plan_runner::{PerformError, Performed, perform};
use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_client::experiment_text;
use armbridge_client::transport::Intent;
use armbridge_link::experiment::Experiment;
use armbridge_link::message::{Command, Settings};
use armbridge_link::server::Touch;
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardClient, BoardUri, Options, Pace};
use armbridge_sim::plant::Plant;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arguments::{angles, pair, seconds};
use crate::connection::Connection;
use crate::errors::value_error;
use crate::identify::{Fit, WeightError};
use crate::motion::Motion;
use crate::periodic::{Stream, Torque};
use crate::plant::PlantArgument;
use crate::settings;
use crate::status::Status;
use crate::telemetry::Telemetry;

/// Connects to a board and waits until it has reported itself.
///
/// `link` is `sim:`, `emulate:`, `usb:`, `serial:`, `tcp://HOST:PORT` or `pty:` as in the host
/// tool. A simulated board has its arm at `initial` angles in rad, and runs in step with the wall
/// clock. `log` is the path of a log to be written.
#[pyfunction]
#[pyo3(signature = (link = "sim:", *, log = None, plant = None, friction = true, initial = None, seed = 1, observe = false))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn connect(
    py: Python<'_>,
    link: &str,
    log: Option<PathBuf>,
    plant: Option<PlantArgument>,
    friction: bool,
    initial: Option<&Bound<'_, PyAny>>,
    seed: u64,
    observe: bool,
) -> PyResult<Board> {
    let uri: BoardUri = link.parse().map_err(value_error)?;
    let initial = initial.map(|q| pair(q, "angles in rad")).transpose()?;
    let mut config = PlantArgument::or_default(plant)?;
    if let Some(initial) = initial {
        config.initial.q = initial.into();
    }
    config.friction_on &= friction;
    let options = move || {
        let mut options = Options::new(Bench::new(Plant::new(config, seed)));
        options.pace = Pace::WallClock;
        options.is_stoppable = true;
        options.link.is_quiet = true;
        options.link.intent = if observe {
            Intent::Observe
        } else {
            Intent::Command
        };
        options
    };
    Ok(Board(Connection::open(py, uri, options, log.as_deref())?))
}

/// A board. A thread of its own serves the link; the board is disarmed, or its arm parked, when it
/// is closed, by the end of its `with` block at the latest.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Board(Arc<Connection>);

#[pymethods]
impl Board {
    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.close(py)
    }

    fn __repr__(&self) -> String {
        format!("<Board {}>", self.0.text())
    }

    /// Parks the arm or disarms, and closes the link and the log.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.0.close(py)
    }

    /// Status of the board.
    fn status(&self) -> PyResult<Status> {
        Ok(Status::from(&self.0.client()?.status()))
    }

    /// Ticks as they arrive.
    #[getter]
    fn telemetry(&self) -> Telemetry {
        Telemetry(Arc::clone(&self.0))
    }

    /// Parameters in force, by name.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        settings::to_dict(py, &self.in_force()?)
    }

    /// The value of a parameter; None if it belongs to another kind of controller or estimator.
    fn get(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        settings::get(py, &self.in_force()?, name)
    }

    /// Replaces parameters, all or none, and keeps them across power-off if `save`.
    #[pyo3(signature = (parameters, *, save = false))]
    fn set(&self, py: Python<'_>, parameters: &Bound<'_, PyDict>, save: bool) -> PyResult<()> {
        let after = settings::changed(&self.in_force()?, parameters)?;
        self.0.call(py, |client| client.set(&after, save))
    }

    /// Arms the board for a `with` block, by whose end the arm is parked or the board disarmed.
    fn armed(&self) -> Armed {
        Armed(Arc::clone(&self.0))
    }

    /// Arms the board: returns when its motors have been checked.
    fn arm(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::arm)
    }

    /// Disarms: torque is off at once.
    fn disarm(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::disarm)
    }

    /// Moves the arm to the pose of `park.angle_rad`, lowers it there and disarms; disarms without a
    /// pose.
    fn park(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::park)
    }

    /// Emergency stop: torque off, until `clear`.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::stop)
    }

    /// Clears a fault.
    fn clear(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::clear)
    }

    /// Holds the arm at these angles in rad, of shape (2,): a step, if it is elsewhere.
    fn regulate(&self, py: Python<'_>, q: &Bound<'_, PyAny>) -> PyResult<()> {
        self.0.command(py, Command::Regulate(angles(q)?))
    }

    /// Moves the arm to these angles in rad, of shape (2,), with least jerk: in `duration` s, or as
    /// fast as the board's bounds permit.
    #[pyo3(signature = (q, duration = None))]
    fn move_to(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        duration: Option<f64>,
    ) -> PyResult<Motion> {
        let to_rad = angles(q)?;
        duration.map(seconds).transpose()?;
        let duration_s = duration.map(|it| it as f32);
        let motion = self
            .0
            .call(py, |client| client.move_to(to_rad, duration_s))?;
        Ok(Motion(Arc::clone(&self.0), motion))
    }

    /// Makes the arm weightless, for a hand to lead.
    fn float(&self, py: Python<'_>) -> PyResult<()> {
        self.0.command(py, Command::Float)
    }

    /// Performs an experiment from where the arm is: a dictionary as a step of a scenario has it, of
    /// `roles`, `duration_s`, `angle_rad` and `speed_rad_s`. Returns whether it lasted its whole
    /// time, and a sentence that says why it ended; the arm is held then.
    fn experiment(
        &self,
        py: Python<'_>,
        experiment: &Bound<'_, PyDict>,
    ) -> PyResult<(bool, String)> {
        let experiment: Experiment = pythonize::depythonize(experiment)
            .map_err(|error| value_error(format!("this is no experiment: {error}")))?;
        let conclusion = self.0.call(py, |client| client.experiment(&experiment))?;
        let text = experiment_text::conclusion(&conclusion);
        Ok((experiment_text::is_whole(&conclusion), text))
    }

    /// Moves the arm by a plan, a scenario that ships or a file, and identifies it; its records
    /// are in the log of the connection, too. An arm that was not armed is armed for it, and
    /// parked or let go of at the end. `weighed` is the relative standard error of its known weight.
    #[pyo3(signature = (plan = "identify", *, weighed = 0.01))]
    fn identify(&self, py: Python<'_>, plan: &str, weighed: f64) -> PyResult<Fit> {
        let weighed = WeightError::new(weighed)?;
        let overrides = Overrides {
            board: Some(self.in_force()?),
            ..Overrides::default()
        };
        let scenario = Scenario::load(plan, &overrides).map_err(value_error)?;
        let performed = self
            .0
            .call(py, |client| match perform(client, &scenario.plan) {
                Ok(performed) => Ok(Ok(performed)),
                Err(PerformError::Client(error)) => Err(error),
                Err(PerformError::Setting(error)) => Ok(Err(error)),
            })?;
        let Performed { settings, records } = performed.map_err(value_error)?;
        Fit::new(py, FitData::from_records(&settings, &records), weighed)
    }

    /// A stream of setpoints at this rate in Hz, for a `with` block; each is sent `lead` s before
    /// the arm follows it.
    #[pyo3(signature = (rate, *, lead = 0.03))]
    fn stream(&self, rate: f64, lead: f64) -> PyResult<Stream> {
        Stream::new(Arc::clone(&self.0), rate, lead)
    }

    /// Torques of a controller in Python at this rate in Hz, for a `with` block.
    fn torque(&self, rate: f64) -> PyResult<Torque> {
        Torque::new(Arc::clone(&self.0), rate)
    }

    /// Pushes a joint, 1 or 2, of a simulated arm: torque in N m for a duration in s.
    fn push(&self, py: Python<'_>, joint: u8, torque: f32, duration: f64) -> PyResult<()> {
        let duration = seconds(duration)?;
        self.0
            .call(py, |client| client.push(joint, torque, duration))
    }

    /// Brings a simulated arm back to where it began, and holds it there until a motor drives it.
    fn lift(&self) -> PyResult<()> {
        self.0.client()?.thread().touch(Touch::Lift);
        Ok(())
    }
}

impl Board {
    /// The client, without the interpreter.
    pub(crate) fn client(&self) -> PyResult<Arc<BoardClient>> {
        self.0.client()
    }

    fn in_force(&self) -> PyResult<Settings> {
        Ok(self.0.client()?.status().settings.unwrap_or_default())
    }
}

/// The `with` block in which a board is armed.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Armed(Arc<Connection>);

#[pymethods]
impl Armed {
    fn __enter__(&self, py: Python<'_>) -> PyResult<Board> {
        self.0.call(py, BoardClient::arm)?;
        Ok(Board(Arc::clone(&self.0)))
    }

    /// Parks the arm, if it has a pose, and disarms.
    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.0.call(py, BoardClient::park)
    }
}
