//! Arguments from Python, checked: numbers for both joints, and times.

use std::time::Duration;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Two finite numbers, one for each joint; `what` is as "angles in rad".
pub(crate) fn pair(value: &Bound<'_, PyAny>, what: &str) -> PyResult<[f64; 2]> {
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
    // The board's numbers are of single precision.
    if [first, second]
        .iter()
        .all(|value| (*value as f32).is_finite())
    {
        return Ok([first, second]);
    }
    Err(PyValueError::new_err(format!(
        "expected two finite {what}, got [{first}, {second}]"
    )))
}

/// The same for the board.
pub(crate) fn single_pair(value: &Bound<'_, PyAny>, what: &str) -> PyResult<[f32; 2]> {
    Ok(pair(value, what)?.map(|value| value as f32))
}

/// Two angles in rad for the board.
pub(crate) fn angles(value: &Bound<'_, PyAny>) -> PyResult<[f32; 2]> {
    single_pair(value, "angles in rad")
}

/// A time span in s.
pub(crate) fn seconds(value: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(value)
        .map_err(|_| PyValueError::new_err(format!("expected a time in s, got {value}")))
}
