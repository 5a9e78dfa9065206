//! A board: commands, and the contexts in which it is armed.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use armbridge_client::transport::{Intent, LinkOptions};
use armbridge_control::arm::State;
use armbridge_link::message::{Command, Settings};
use armbridge_link::motion::Motion as LinkMotion;
use armbridge_link::server::Touch;
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardClient, BoardUri, ClientError, Options, Pace};
use armbridge_sim::plant::{Plant, PlantConfig, PlantFile};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::errors::{ClosedError, from_client, log_error, value_error};
use crate::motion::Motion;
use crate::periodic::{Stream, Torque};
use crate::settings;
use crate::status::Status;
use crate::telemetry::{Telemetry, seconds};

/// Angles in rad at which the simulated arm is held until a motor drives it.
const INITIAL_RAD: [f64; 2] = [0.30, -0.25];

/// Connections that are open, to be closed when the interpreter ends.
static OPEN: Mutex<Vec<Weak<Connection>>> = Mutex::new(Vec::new());

/// A session with a board, shared by the objects that use it.
pub(crate) struct Connection {
    link: String,
    client: Mutex<Option<Arc<BoardClient>>>,
    recorder: Mutex<Option<Recorder>>,
    /// The exception of a signal that interrupted a call.
    raised: Arc<Mutex<Option<PyErr>>>,
    /// The process that has the link's thread.
    process: u32,
}

impl Connection {
    /// The client.
    pub(crate) fn client(&self) -> PyResult<Arc<BoardClient>> {
        if std::process::id() != self.process {
            return Err(ClosedError::new_err(format!(
                "{} belongs to the parent of this process; connect in the child, too",
                self.link
            )));
        }
        let client = lock(&self.client).clone();
        client.ok_or_else(|| ClosedError::new_err(format!("{} is closed", self.link)))
    }

    /// Makes a call, without the interpreter's lock.
    pub(crate) fn call(
        &self,
        py: Python<'_>,
        call: impl FnOnce(&BoardClient) -> Result<(), ClientError> + Send,
    ) -> PyResult<()> {
        let client = self.client()?;
        let result = py.detach(|| call(&client));
        self.result(py, result)
    }

    pub(crate) fn command(&self, py: Python<'_>, command: Command) -> PyResult<()> {
        self.call(py, |client| client.command(command))
    }

    /// The result of a call, or the exception of the signal that interrupted it.
    pub(crate) fn result<T>(&self, _py: Python<'_>, result: Result<T, ClientError>) -> PyResult<T> {
        result.map_err(|error| match (&error, lock(&self.raised).take()) {
            (ClientError::Interrupted, Some(raised)) => raised,
            _ => from_client(&error),
        })
    }

    /// Ends the session, parking the arm or disarming, and closes the log. Without effect on one
    /// that is closed.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        if std::process::id() != self.process {
            return Ok(());
        }
        let Some(client) = lock(&self.client).take() else {
            return Ok(());
        };
        let recorder = lock(&self.recorder).take();
        let (left, written) = py.detach(|| {
            // Other threads may be in a call, which ends with the link.
            let left = client.leave();
            drop(client);
            (left, recorder.map(Recorder::finish).transpose())
        });
        let written = written.map_err(log_error)?;
        if let Some(trouble) = written.and_then(|report| report.trouble) {
            return Err(log_error(trouble));
        }
        left.map_err(|error| from_client(&error))
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        if std::process::id() == self.process {
            return;
        }
        // The threads that these would wait for are the parent's.
        std::mem::forget(lock(&self.client).take());
        std::mem::forget(lock(&self.recorder).take());
    }
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Two numbers, one for each joint.
pub(crate) fn pair(value: &Bound<'_, PyAny>, what: &str) -> PyResult<[f32; 2]> {
    let kind = || -> PyErr {
        let name = value.get_type().name();
        let name = name.map_or_else(|_| "this".into(), |name| name.to_string());
        PyTypeError::new_err(format!("expected two {what}, got {name}"))
    };
    let items: PyResult<Vec<f64>> = value
        .try_iter()
        .map_err(|_| kind())?
        .map(|item| item?.extract::<f64>().map_err(|_| kind()))
        .collect();
    let items = items?;
    let [first, second] = items[..] else {
        let count = items.len();
        return Err(PyValueError::new_err(format!(
            "expected two {what}, got {count}"
        )));
    };
    let pair = [first as f32, second as f32];
    if pair.iter().all(|value| value.is_finite()) {
        return Ok(pair);
    }
    Err(PyValueError::new_err(format!(
        "expected two finite {what}, got [{first}, {second}]"
    )))
}

/// Two angles in rad.
pub(crate) fn angles(value: &Bound<'_, PyAny>) -> PyResult<[f32; 2]> {
    pair(value, "angles in rad")
}

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
    plant: Option<&str>,
    friction: bool,
    initial: Option<&Bound<'_, PyAny>>,
    seed: u64,
    observe: bool,
) -> PyResult<Board> {
    let uri: BoardUri = link.parse().map_err(value_error)?;
    let initial = initial.map(angles).transpose()?;
    let initial = initial.map_or(INITIAL_RAD, |it| it.map(f64::from));
    let mut config = match plant {
        Some(name) => PlantFile::load(name).map_err(value_error)?.config(initial),
        None => PlantConfig {
            initial: State::at_rest(initial.into()),
            ..PlantConfig::default()
        },
    };
    config.friction_on &= friction;
    let facts = RunFacts::from_settings("python", &uri.world(), &Settings::default());
    let recorder = log.map(|path| Recorder::create(&path, &facts)).transpose();
    let recorder = recorder.map_err(log_error)?;
    let taps = recorder.iter().map(Recorder::tap).collect();
    let raised = Arc::new(Mutex::new(None));
    #[expect(
        clippy::redundant_closure_for_method_calls,
        reason = "its lifetime is not general"
    )]
    let is_interrupted = {
        let raised = Arc::clone(&raised);
        move || {
            let signals = Python::attach(|py| py.check_signals());
            let is_raised = signals.is_err();
            if let Err(error) = signals {
                *lock(&raised) = Some(error);
            }
            is_raised
        }
    };
    let options = move || {
        let mut options = Options::new(Bench::new(Plant::new(config, seed)));
        options.pace = Pace::WallClock;
        options.is_stoppable = true;
        options.link = LinkOptions {
            is_quiet: true,
            intent: if observe {
                Intent::Observe
            } else {
                Intent::Command
            },
            taps,
            ..LinkOptions::default()
        };
        options
    };
    let opened = py.detach(|| BoardClient::open(uri, options, is_interrupted));
    let connection = Connection {
        link: link.to_owned(),
        client: Mutex::new(None),
        recorder: Mutex::new(recorder),
        raised,
        process: std::process::id(),
    };
    let client = connection.result(py, opened)?;
    *lock(&connection.client) = Some(Arc::new(client));
    let connection = Arc::new(connection);
    let mut open = lock(&OPEN);
    open.retain(|it| it.strong_count() > 0);
    open.push(Arc::downgrade(&connection));
    Ok(Board(connection))
}

/// Closes every connection, when the interpreter ends.
#[pyfunction]
pub(crate) fn close_all(py: Python<'_>) {
    let open = std::mem::take(&mut *lock(&OPEN));
    for connection in open.iter().filter_map(Weak::upgrade) {
        // Nobody is left who could be told.
        let _ = connection.close(py);
    }
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
        let is_open = lock(&self.0.client).is_some();
        format!(
            "<Board {}{}>",
            self.0.link,
            if is_open { "" } else { ", closed" }
        )
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

    /// Parks the arm, if it has a pose and is driven, and disarms.
    fn disarm(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::disarm)
    }

    /// Moves the arm to the pose of `park.angle_rad`, lowers it there and disarms; disarms without a
    /// pose.
    fn park(&self, py: Python<'_>) -> PyResult<()> {
        self.0.call(py, BoardClient::disarm)
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
        let after_tick = self
            .0
            .client()?
            .status()
            .record
            .map_or(0, |record| record.tick);
        let motion = LinkMotion::MinimumJerk {
            to_rad,
            duration_s: duration.map(|it| it as f32),
        };
        self.0.command(py, Command::Follow(motion))?;
        Ok(Motion {
            connection: Arc::clone(&self.0),
            goal_rad: to_rad,
            after_tick,
        })
    }

    /// Makes the arm weightless, for a hand to lead.
    fn float(&self, py: Python<'_>) -> PyResult<()> {
        self.0.command(py, Command::Float)
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
    fn push(&self, joint: u8, torque: f32, duration: f64) -> PyResult<()> {
        let touch = Touch::Push {
            joint: joint.wrapping_sub(1),
            torque_nm: torque,
            duration_us: seconds(duration)?.as_micros() as u32,
        };
        touch
            .check()
            .map_err(|refusal| value_error(format!("the arm cannot be pushed: {refusal:?}")))?;
        self.0.client()?.thread().touch(touch);
        Ok(())
    }

    /// Brings a simulated arm back to where it began, and holds it there until a motor drives it.
    fn lift(&self) -> PyResult<()> {
        self.0.client()?.thread().touch(Touch::Lift);
        Ok(())
    }
}

impl Board {
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

    /// Parks the arm or disarms, unless a fault has done so.
    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        let is_armed = Status::from(&self.0.client()?.status()).is_armed();
        if is_armed {
            self.0.call(py, BoardClient::disarm)?;
        }
        Ok(())
    }
}
