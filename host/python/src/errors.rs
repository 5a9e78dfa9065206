//! Exceptions by kind, each with the sentence of the host tool.
//!
//! Arguments of a wrong kind, shape or value are `TypeError` and `ValueError`, and what does not
//! happen in time is `TimeoutError`, as elsewhere in Python.

use std::fmt::Display;

use armbridge_sim::link::ClientError;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use serde::Serialize;

create_exception!(
    armbridge,
    ArmbridgeError,
    PyException,
    "Base of the package's exceptions."
);
create_exception!(
    armbridge,
    LinkError,
    ArmbridgeError,
    "The link to the board could not be opened, or has ended."
);
create_exception!(
    armbridge,
    ClosedError,
    ArmbridgeError,
    "The board was closed, or belongs to the parent of this process."
);
create_exception!(
    armbridge,
    RefusedError,
    ArmbridgeError,
    "The board refuses a command."
);
create_exception!(
    armbridge,
    FaultError,
    ArmbridgeError,
    "The board has switched torque off; `clear` ends that."
);
create_exception!(
    armbridge,
    DroppedError,
    ArmbridgeError,
    "A stop or a disarm overtook the command, or the board was reset."
);
create_exception!(
    armbridge,
    ObserverError,
    ArmbridgeError,
    "Another program commands the board."
);
create_exception!(
    armbridge,
    LogError,
    ArmbridgeError,
    "A log cannot be read or written."
);

create_exception!(
    armbridge,
    IdentifyError,
    ArmbridgeError,
    "The records do not identify the arm."
);

/// The exception of a call to a board.
pub(crate) fn from_client(error: &ClientError) -> PyErr {
    let text = error.to_string();
    match error {
        ClientError::Link(_) | ClientError::Ended => LinkError::new_err(text),
        ClientError::Refused { .. } | ClientError::NotArmed(_) => RefusedError::new_err(text),
        ClientError::Fault(..) => FaultError::new_err(text),
        ClientError::Dropped | ClientError::Interrupted => DroppedError::new_err(text),
        ClientError::Push => PyValueError::new_err(text),
        ClientError::Timeout { .. } => PyTimeoutError::new_err(text),
        ClientError::Observes(_) => ObserverError::new_err(text),
    }
}

/// `ValueError` with this text.
pub(crate) fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The exception of a log.
pub(crate) fn log_error(error: impl Display) -> PyErr {
    LogError::new_err(error.to_string())
}

/// A value of Rust as dictionaries, lists, numbers and strings.
pub(crate) fn to_python(py: Python<'_>, value: &impl Serialize) -> PyResult<Py<PyAny>> {
    Ok(pythonize::pythonize(py, value)?.unbind())
}
