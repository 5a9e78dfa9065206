//! Equations of motion of the arm, by the board's own code, in double precision.

use armbridge_control::arm::{Parameters, State};
use nalgebra::{SMatrix, Vector2};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::pair;
use crate::errors::value_error;
use crate::plant::PlantArgument;

type Vector<'py> = Bound<'py, PyArray1<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// Model of the arm: two links, gravity, and viscous friction. Angles are in rad from upright,
/// torques in N m, all of shape (2,).
#[pyclass(frozen, module = "armbridge")]
pub(crate) struct Arm(Parameters<f64>);

fn vector(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Vector2<f64>> {
    pair(value, what).map(Vector2::from)
}

fn column(py: Python<'_>, value: Vector2<f64>) -> Vector<'_> {
    PyArray1::from_slice(py, value.as_slice())
}

fn matrix<const R: usize, const C: usize>(
    py: Python<'_>,
    value: SMatrix<f64, R, C>,
) -> PyResult<Matrix<'_>> {
    let rows = value.row_iter().map(|row| row.iter().copied().collect());
    PyArray2::from_vec2(py, &rows.collect::<Vec<Vec<f64>>>()).map_err(value_error)
}

#[pymethods]
impl Arm {
    /// The arm of the paper, or that of a virtual arm, of a plant file, or of one that ships.
    #[new]
    #[pyo3(signature = (plant = None))]
    fn new(plant: Option<PlantArgument>) -> PyResult<Self> {
        let plant = plant.map(PlantArgument::config).transpose()?;
        Ok(Self(
            plant.map_or_else(Parameters::paper, |plant| plant.true_arm()),
        ))
    }

    /// Mass matrix in kg m^2, of shape (2, 2).
    fn mass<'py>(&self, py: Python<'py>, q: &Bound<'_, PyAny>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.mass(vector(q, "angles in rad")?))
    }

    /// Coriolis matrix, of shape (2, 2): its product with the speeds is a torque.
    fn coriolis<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'_, PyAny>,
        dq: &Bound<'_, PyAny>,
    ) -> PyResult<Matrix<'py>> {
        let (q, dq) = (vector(q, "angles in rad")?, vector(dq, "speeds in rad/s")?);
        matrix(py, self.0.coriolis(q, dq))
    }

    /// Torque of gravity in N m.
    fn gravity<'py>(&self, py: Python<'py>, q: &Bound<'_, PyAny>) -> PyResult<Vector<'py>> {
        Ok(column(py, self.0.gravity(vector(q, "angles in rad")?)))
    }

    /// Acceleration in rad/s^2 under a torque of the motors.
    fn acceleration<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'_, PyAny>,
        dq: &Bound<'_, PyAny>,
        torque: &Bound<'_, PyAny>,
    ) -> PyResult<Vector<'py>> {
        let state = State {
            q: vector(q, "angles in rad")?,
            dq: vector(dq, "speeds in rad/s")?,
        };
        let torque = vector(torque, "torques in N m")?;
        Ok(column(py, self.0.acceleration(&state, torque)))
    }

    /// Kinetic and potential energy in J; the latter is 0 with both links level.
    fn energy(&self, q: &Bound<'_, PyAny>, dq: &Bound<'_, PyAny>) -> PyResult<f64> {
        let state = State {
            q: vector(q, "angles in rad")?,
            dq: vector(dq, "speeds in rad/s")?,
        };
        Ok(self.0.energy(&state))
    }

    /// Matrices A of shape (4, 4) and B of shape (4, 2) of the arm at rest at these angles, with the
    /// state of angles and speeds.
    fn linearise<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'_, PyAny>,
    ) -> PyResult<(Matrix<'py>, Matrix<'py>)> {
        let linear = self.0.linearise(vector(q, "angles in rad")?);
        Ok((matrix(py, linear.a)?, matrix(py, linear.b)?))
    }

    fn __repr__(&self) -> String {
        let [first, second] = self.0.weight_nm();
        format!("<Arm of {first:.3} and {second:.3} N m of weight>")
    }
}
