//! Virtual arms.

use armbridge_link::message::Settings;
use armbridge_sim::plant::robot_description::RobotFormat;
use armbridge_sim::plant::{PlantConfig, PlantFile};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::value_error;
use crate::settings;

/// A virtual arm: links, friction, motors and encoders, wherever it is.
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Plant(pub(crate) PlantConfig);

#[pymethods]
impl Plant {
    /// The default arm, that of a plant file, or one that ships.
    #[new]
    #[pyo3(signature = (name = None))]
    fn new(name: Option<&str>) -> PyResult<Self> {
        PlantFile::arm(name, None).map(Self).map_err(value_error)
    }

    /// The arm that a board with these parameters takes its own for.
    #[staticmethod]
    fn of_board(parameters: &Bound<'_, PyDict>) -> PyResult<Self> {
        let board = settings::changed(&Settings::default(), parameters)?;
        Ok(Self(PlantConfig::of_board(&board)))
    }

    /// This arm with masses, inertias, friction and motor gains that are each off by a factor from
    /// `1 - spread` to `1 + spread`; a pure function of its arguments.
    fn varied(&self, spread: f64, seed: u64) -> PyResult<Self> {
        if !(0.0..=0.9).contains(&spread) {
            return Err(value_error(format!(
                "expected a spread from 0 to 0.9, got {spread}"
            )));
        }
        Ok(Self(self.0.varied(seed, spread)))
    }

    /// The arm as a model of MuJoCo.
    fn mjcf(&self) -> PyResult<String> {
        RobotFormat::Mjcf.describe(&self.0).map_err(value_error)
    }

    /// The arm as URDF.
    fn urdf(&self) -> PyResult<String> {
        RobotFormat::Urdf.describe(&self.0).map_err(value_error)
    }

    /// The arm as a plant file.
    fn to_toml(&self) -> PyResult<String> {
        let file = PlantFile::from_config(&self.0).without_position();
        toml::to_string(&file).map_err(value_error)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let [first, second] = self.0.arm.weight_nm();
        format!("<Plant of {first:.3} and {second:.3} N m of weight>")
    }
}

/// A virtual arm as an argument: one, or the name of one.
#[derive(FromPyObject)]
pub(crate) enum PlantArgument {
    Plant(Py<Plant>),
    Name(String),
}

impl PlantArgument {
    /// The arm, where one is given.
    pub(crate) fn or_default(plant: Option<Self>) -> PyResult<PlantConfig> {
        plant.map_or_else(
            || PlantFile::arm(None, None).map_err(value_error),
            Self::config,
        )
    }

    /// The arm.
    pub(crate) fn config(self) -> PyResult<PlantConfig> {
        match self {
            Self::Plant(plant) => Ok(plant.get().0),
            Self::Name(name) => PlantFile::arm(Some(&name), None).map_err(value_error),
        }
    }

    /// The arm as in a file.
    pub(crate) fn file(self) -> PyResult<PlantFile> {
        match self {
            Self::Plant(plant) => Ok(PlantFile::from_config(&plant.get().0).without_position()),
            Self::Name(name) => PlantFile::load(&name).map_err(value_error),
        }
    }
}
