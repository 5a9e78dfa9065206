//! Parameters of the board as Python values: booleans, numbers, strings, and sequences of these.

use armbridge_client::params;
use armbridge_client::params::Parameter;
use armbridge_link::message::Settings;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use toml::Value;

use crate::errors::value_error;

/// These settings with the parameters of a dictionary replaced.
pub(crate) fn changed(before: &Settings, parameters: &Bound<'_, PyDict>) -> PyResult<Settings> {
    let pairs = pairs(parameters)?;
    let pairs = pairs.iter().map(|(key, value)| (key.as_str(), value));
    params::replaced(before, pairs).map_err(value_error)
}

/// The parameters of a dictionary, not checked.
pub(crate) fn pairs(parameters: &Bound<'_, PyDict>) -> PyResult<Vec<(String, Value)>> {
    let pairs = parameters.iter().map(|(key, value)| {
        let key: String = key
            .extract()
            .map_err(|_| PyTypeError::new_err("names of parameters are strings"))?;
        let value = from_python(&value, &key)?;
        Ok((key, value))
    });
    pairs.collect()
}

/// All parameters in force, by name.
pub(crate) fn to_dict<'py>(py: Python<'py>, settings: &Settings) -> PyResult<Bound<'py, PyDict>> {
    pairs_to_dict(py, &params::pairs(settings))
}

/// These parameters, by name.
pub(crate) fn pairs_to_dict<'py>(
    py: Python<'py>,
    pairs: &[(&Parameter, Value)],
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (parameter, value) in pairs {
        all.set_item(parameter.key, to_python(py, value)?)?;
    }
    Ok(all)
}

/// The value of one parameter.
pub(crate) fn get(py: Python<'_>, settings: &Settings, key: &str) -> PyResult<Py<PyAny>> {
    if params::find(key).is_none() {
        return Err(value_error(params::unknown(key)));
    }
    match params::get(settings, key) {
        Some(value) => to_python(py, &value),
        // It belongs to another kind of controller or estimator.
        None => Ok(py.None()),
    }
}

fn from_python(value: &Bound<'_, PyAny>, key: &str) -> PyResult<Value> {
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(value.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.extract()?));
    }
    // Sequences and arrays; and the scalars of NumPy, which are neither.
    if let Ok(items) = value.try_iter() {
        let items: PyResult<Vec<Value>> = items.map(|item| from_python(&item?, key)).collect();
        return Ok(Value::Array(items?));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Value::Float(number));
    }
    let kind = value.get_type().name()?;
    Err(PyTypeError::new_err(format!(
        "`{key}` cannot be of type {kind}: expected a boolean, a number, a string, or a sequence of \
         these"
    )))
}

fn to_python(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    match value {
        Value::Boolean(value) => value.into_py_any(py),
        Value::Integer(value) => value.into_py_any(py),
        Value::Float(value) => value.into_py_any(py),
        Value::String(value) => value.into_py_any(py),
        Value::Array(items) => {
            let items: PyResult<Vec<_>> = items.iter().map(|item| to_python(py, item)).collect();
            PyList::new(py, items?)?.into_py_any(py)
        }
        // No parameter is one.
        Value::Datetime(_) | Value::Table(_) => value.to_string().into_py_any(py),
    }
}
