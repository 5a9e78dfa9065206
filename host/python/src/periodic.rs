//! Streams of setpoints, and torques, at a fixed rate.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use armbridge_link::message::Command;
use armbridge_sim::link::{BoardClient, CommandSender, SetpointSender};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arguments::{angles, seconds, single_pair};
use crate::connection::{Connection, lock};
use crate::errors::from_client;

/// Period at which a call that waits looks for signals.
const LOOK: Duration = Duration::from_millis(50);
/// Highest rate in Hz: a command is sent when the one before has been answered, some ticks later.
const RATE_MAX_HZ: f64 = 250.0;

/// Period of a rate in Hz.
pub(crate) fn period(rate: f64) -> PyResult<Duration> {
    if rate > 0.0 && rate <= RATE_MAX_HZ {
        return seconds(1.0 / rate);
    }
    Err(PyValueError::new_err(format!(
        "expected a rate above 0 and at most {RATE_MAX_HZ} Hz, got {rate}; a motion that the board \
         computes itself needs no rate"
    )))
}

/// A deadline that has been reached.
type Latest = Arc<Mutex<Option<Instant>>>;

/// Times of a fixed rate, against deadlines that do not drift.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Ticks {
    begun: Instant,
    period: Duration,
    count: u32,
    next: Mutex<u32>,
    /// The latest deadline, for the stream.
    latest: Latest,
}

impl Ticks {
    fn new(period: Duration, duration_s: f64, latest: Latest) -> PyResult<Self> {
        let count = seconds(duration_s)?.as_secs_f64() / period.as_secs_f64();
        Ok(Self {
            begun: Instant::now(),
            period,
            count: count.round() as u32,
            next: Mutex::new(0),
            latest,
        })
    }
}

#[pymethods]
impl Ticks {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    /// Waits for the next deadline. Returns its time in s since the first.
    fn __next__(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        let index = {
            let mut next = lock(&self.next);
            if *next == self.count {
                return Ok(None);
            }
            *next += 1;
            *next - 1
        };
        let due = self.begun + self.period * index;
        loop {
            let left = due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                *lock(&self.latest) = Some(due);
                return Ok(Some((self.period * index).as_secs_f64()));
            }
            py.detach(|| std::thread::sleep(left.min(LOOK)));
            py.check_signals()?;
        }
    }

    fn __len__(&self) -> usize {
        self.count as usize
    }
}

/// A stream of setpoints, which the board interpolates.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Stream {
    connection: Arc<Connection>,
    period: Duration,
    setpoints: Mutex<SetpointSender>,
    late: Mutex<u64>,
    latest: Latest,
}

impl Stream {
    pub(crate) fn new(connection: Arc<Connection>, rate: f64, lead: f64) -> PyResult<Self> {
        Ok(Self {
            connection,
            period: period(rate)?,
            setpoints: Mutex::new(SetpointSender::new(seconds(lead)?)),
            late: Mutex::new(0),
            latest: Arc::default(),
        })
    }
}

#[pymethods]
impl Stream {
    /// Deadlines for this many seconds.
    fn ticks(&self, duration: f64) -> PyResult<Ticks> {
        Ticks::new(self.period, duration, Arc::clone(&self.latest))
    }

    /// Sends the setpoint of the latest deadline of `ticks`, or of this moment without one: angles in
    /// rad, and speeds in rad/s unless the board is to compute them. The arm is there one lead
    /// later; it joins the stream within 0.2 s.
    #[pyo3(signature = (q, dq = None))]
    fn send(&self, q: &Bound<'_, PyAny>, dq: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let angle_rad = angles(q)?;
        let speed_rad_s = dq
            .map(|dq| single_pair(dq, "speeds in rad/s"))
            .transpose()?;
        let client = self.connection.client()?;
        let deadline = lock(&self.latest).take().unwrap_or_else(Instant::now);
        let sent = lock(&self.setpoints).send(&client, deadline, angle_rad, speed_rad_s);
        if sent.map_err(|error| from_client(&error))? {
            *lock(&self.late) += 1;
        }
        Ok(())
    }

    /// Number of setpoints that came too late for the board, which leaves them out.
    #[getter]
    fn late(&self) -> u64 {
        *lock(&self.late)
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    /// Ends the stream: the board brakes the arm after its last setpoint, and holds it.
    #[pyo3(signature = (*_error))]
    #[expect(clippy::unused_self, reason = "a method of Python")]
    fn __exit__(&self, _error: &Bound<'_, PyTuple>) {}
}

/// Torques of a controller in Python.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Torque {
    connection: Arc<Connection>,
    period: Duration,
    commands: Mutex<CommandSender>,
}

impl Torque {
    pub(crate) fn new(connection: Arc<Connection>, rate: f64) -> PyResult<Self> {
        Ok(Self {
            connection,
            period: period(rate)?,
            commands: Mutex::default(),
        })
    }
}

#[pymethods]
impl Torque {
    /// Deadlines for this many seconds.
    fn ticks(&self, duration: f64) -> PyResult<Ticks> {
        Ticks::new(self.period, duration, Arc::default())
    }

    /// Sends torques in N m, which stay until the next ones, or until they are older than
    /// `limits.torque_age_ms`: then torque is off.
    fn send(&self, torque: &Bound<'_, PyAny>) -> PyResult<()> {
        let torque_nm = single_pair(torque, "torques in N m")?;
        let client = self.connection.client()?;
        let sent = lock(&self.commands).send(&client, Command::Torque(torque_nm));
        sent.map(|_| ()).map_err(|error| from_client(&error))
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    /// Ends the torque: the board holds the arm where it is, or disarms if it cannot.
    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.connection.call(py, BoardClient::hold)
    }
}
