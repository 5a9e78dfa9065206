//! Environments for learned controllers, as arrays; `armbridge.gym` makes Gymnasium's of them.

use std::sync::{Mutex, MutexGuard, PoisonError};

use armbridge_link::message::{Fault, Settings, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::environment::batch::Batch;
use armbridge_sim::environment::{
    ActionKind, Description, Environment, EnvironmentError, Mode, Observation, Task,
};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::pair;
use crate::board::Board;
use crate::errors::{from_client, value_error};
use crate::plant::PlantArgument;
use crate::settings;

type Vector<'py, T> = Bound<'py, PyArray1<T>>;
type Matrix<'py, T> = Bound<'py, PyArray2<T>>;
type Step<'py> = (Vector<'py, f32>, f64, bool, bool);
type Steps<'py> = (
    Matrix<'py, f32>,
    Vector<'py, f64>,
    Vector<'py, bool>,
    Vector<'py, bool>,
);

/// The value with this name.
fn named<T: Copy>(what: &str, name: &str, all: &[(&str, T)]) -> PyResult<T> {
    let found = all.iter().find(|(known, _)| *known == name);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        let names = names.join(" or ");
        value_error(format!("there is no {what} `{name}`: expected {names}"))
    })
}

/// Virtual arms as an argument: one, or a sequence.
#[derive(FromPyObject)]
enum Plants {
    One(PlantArgument),
    Many(Vec<PlantArgument>),
}

/// Describes environments, with the settings of the set-up that holds best where none are given.
fn description(
    task: &str,
    mode: &str,
    action: &str,
    settings: Option<&Bound<'_, PyDict>>,
    plant: Option<Plants>,
    ticks: u32,
    steps: u32,
) -> PyResult<Description> {
    let before = Settings {
        setup: Setup::best(),
        ..Settings::default()
    };
    let plants = match plant {
        None => vec![PlantArgument::or_default(None)?],
        Some(Plants::One(plant)) => vec![plant.config()?],
        Some(Plants::Many(plants)) => {
            let plants = plants.into_iter().map(PlantArgument::config);
            plants.collect::<PyResult<_>>()?
        }
    };
    Ok(Description {
        task: named(
            "task",
            task,
            &[("balance", Task::Balance), ("reach", Task::Reach)],
        )?,
        mode: named(
            "mode",
            mode,
            &[("exact", Mode::Exact), ("fast", Mode::Fast)],
        )?,
        action: named(
            "action",
            action,
            &[
                ("torque", ActionKind::Torque),
                ("setpoint", ActionKind::Setpoint),
                ("pwm", ActionKind::Pwm),
            ],
        )?,
        settings: match settings {
            Some(parameters) => settings::changed(&before, parameters)?,
            None => before,
        },
        plants,
        ticks_per_step: ticks,
        steps_max: steps,
    })
}

fn to_error(error: &EnvironmentError) -> PyErr {
    match error {
        EnvironmentError::NoPlant
        | EnvironmentError::Ticks { .. }
        | EnvironmentError::Action(_)
        | EnvironmentError::OneBoard
        | EnvironmentError::Settings(_) => value_error(error),
        EnvironmentError::NotReset | EnvironmentError::Exact(_) => {
            PyRuntimeError::new_err(error.to_string())
        }
        EnvironmentError::Client(error) => from_client(error),
    }
}

/// Observations as an array of shape (n, k).
fn matrix(py: Python<'_>, values: Vec<f32>, count: usize) -> PyResult<Matrix<'_, f32>> {
    let width = values.len().checked_div(count).unwrap_or(0);
    values.into_pyarray(py).reshape([count, width])
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One environment, see `armbridge.gym`. `board` is a board to run it on instead of a simulated one.
#[pyclass(frozen, name = "Environment", module = "armbridge")]
pub(crate) struct PyEnvironment(Mutex<Environment>);

impl PyEnvironment {
    /// Works on the environment without the interpreter's lock, which a connected board may need
    /// meanwhile.
    fn with<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Environment) -> T + Send) -> T {
        py.detach(|| work(&mut lock(&self.0)))
    }
}

fn vector(environment: &Environment, observation: &Observation) -> Vec<f32> {
    let task = environment.description().task;
    let mut values = vec![0.0; task.vector_len()];
    task.write_vector(observation, environment.target_rad(), &mut values);
    values
}

#[pymethods]
impl PyEnvironment {
    #[new]
    #[pyo3(signature = (task, *, mode = "fast", action = "torque", settings = None, plant = None, ticks = 20, steps = 250, board = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        task: &str,
        mode: &str,
        action: &str,
        settings: Option<&Bound<'_, PyDict>>,
        plant: Option<Plants>,
        ticks: u32,
        steps: u32,
        board: Option<PyRef<'_, Board>>,
    ) -> PyResult<Self> {
        let description = description(task, mode, action, settings, plant, ticks, steps)?;
        let environment = match board {
            Some(board) => Environment::on_board(board.client()?, &description),
            None => Environment::new(description),
        };
        let environment = environment.map_err(|error| to_error(&error))?;
        Ok(Self(Mutex::new(environment)))
    }

    /// Smallest and largest actions, each of shape (2,).
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> [Vector<'py, f64>; 2] {
        let bounds = self.with(py, |environment| {
            let description = environment.description();
            description.action.bounds(&description.settings)
        });
        [0, 1].map(|end| PyArray1::from_iter(py, bounds.iter().map(|joint| joint[end])))
    }

    /// Length of an observation.
    #[getter]
    fn observations(&self, py: Python<'_>) -> usize {
        self.with(py, |environment| {
            environment.description().task.vector_len()
        })
    }

    /// Begins an episode, after seeding the generator of episodes if `seed` is given.
    #[pyo3(signature = (seed = None))]
    fn reset<'py>(&self, py: Python<'py>, seed: Option<u64>) -> PyResult<Vector<'py, f32>> {
        let observed = self.with(py, |environment| {
            if let Some(seed) = seed {
                environment.seed(seed);
            }
            let observation = environment.reset()?;
            Ok(vector(environment, &observation))
        });
        let observed = observed.map_err(|error| to_error(&error))?;
        Ok(observed.into_pyarray(py))
    }

    /// Runs a step: observation, reward, whether the episode has ended, whether it was truncated.
    fn step<'py>(&self, py: Python<'py>, action: &Bound<'_, PyAny>) -> PyResult<Step<'py>> {
        let action = pair(action, "actions")?;
        let stepped = self.with(py, |environment| {
            let transition = environment.step(action)?;
            Ok((vector(environment, &transition.observation), transition))
        });
        let (observed, transition) = stepped.map_err(|error| to_error(&error))?;
        Ok((
            observed.into_pyarray(py),
            transition.reward,
            transition.is_terminated,
            transition.is_truncated,
        ))
    }

    /// The last tick, and the true angles and speeds of a simulated arm.
    #[getter]
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let info = PyDict::new(py);
        let (observation, state) = self.with(py, |environment| {
            (environment.observation().copied(), environment.true_state())
        });
        if let Some(observation) = observation {
            let array = |values: [f32; JOINTS]| PyArray1::from_slice(py, &values);
            info.set_item("torque_nm", array(observation.torque_nm))?;
            info.set_item("pwm", PyArray1::from_slice(py, &observation.pwm))?;
            info.set_item("fault", observation.fault.map(Fault::name))?;
        }
        if let Some(state) = state {
            info.set_item(
                "true_angle_rad",
                PyArray1::from_slice(py, state.q.as_slice()),
            )?;
            info.set_item(
                "true_speed_rad_s",
                PyArray1::from_slice(py, state.dq.as_slice()),
            )?;
        }
        Ok(info)
    }
}

/// So many environments like another one, which are stepped on all processors.
#[pyclass(frozen, name = "Environments", module = "armbridge")]
pub(crate) struct PyEnvironments {
    batch: Mutex<Batch>,
    count: usize,
}

/// Observations of all, one after the other.
fn vectors<'a>(batch: &Batch, observations: impl Iterator<Item = &'a Observation>) -> Vec<f32> {
    let all = batch.environments().iter().zip(observations);
    all.flat_map(|(environment, observation)| vector(environment, observation))
        .collect()
}

#[pymethods]
impl PyEnvironments {
    #[new]
    fn new(environment: &PyEnvironment, py: Python<'_>, count: usize) -> PyResult<Self> {
        let batch = environment.with(py, |environment| Batch::new(environment, count));
        Ok(Self {
            batch: Mutex::new(batch.map_err(|error| to_error(&error))?),
            count,
        })
    }

    /// Begins an episode in each; `seeds` has one for each, or None.
    fn reset<'py>(&self, py: Python<'py>, seeds: Vec<Option<u64>>) -> PyResult<Matrix<'py, f32>> {
        let count = self.count;
        if seeds.len() != count {
            let given = seeds.len();
            return Err(value_error(format!("expected {count} seeds, got {given}")));
        }
        let observed = py.detach(|| {
            let mut batch = lock(&self.batch);
            let observation = batch.reset(&seeds)?;
            Ok(vectors(&batch, observation.iter()))
        });
        matrix(py, observed.map_err(|error| to_error(&error))?, count)
    }

    /// Runs a step of each, with actions of shape (n, 2): observations, rewards, whether the episodes
    /// have ended, whether they were truncated. The step after the end of an episode begins the next.
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Steps<'py>> {
        let count = self.count;
        if actions.shape() != [count, JOINTS] {
            let shape = actions.shape();
            return Err(value_error(format!(
                "expected actions of shape ({count}, {JOINTS}), got {shape:?}"
            )));
        }
        let rows = actions.as_array();
        let actions: Vec<[f64; JOINTS]> =
            rows.rows().into_iter().map(|it| [it[0], it[1]]).collect();
        let stepped = py.detach(|| {
            let mut batch = lock(&self.batch);
            let transitions = batch.step(&actions)?;
            let observation = transitions.iter().map(|it| &it.observation);
            Ok((vectors(&batch, observation), transitions))
        });
        let (observed, transitions) = stepped.map_err(|error| to_error(&error))?;
        let rewards = transitions.iter().map(|it| it.reward);
        let terminated = transitions.iter().map(|it| it.is_terminated);
        let truncated = transitions.iter().map(|it| it.is_truncated);
        Ok((
            matrix(py, observed, count)?,
            PyArray1::from_iter(py, rewards),
            PyArray1::from_iter(py, terminated),
            PyArray1::from_iter(py, truncated),
        ))
    }
}
