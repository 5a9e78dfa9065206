//! Access to the reference numbers.

use std::sync::LazyLock;

use armbridge_control::arm::Discrete;
use nalgebra::{SMatrix, SVector};
use serde_json::Value;

static FILE: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../data/paper-reference.json")).expect("valid JSON")
});

/// The value at a path of keys.
pub(crate) fn at(path: &[&str]) -> &'static Value {
    path.iter().fold(&*FILE, |value, key| {
        value
            .get(key)
            .unwrap_or_else(|| panic!("no {key} in {path:?}"))
    })
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

pub(crate) fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

pub(crate) fn vector<const N: usize>(value: &Value) -> SVector<f64, N> {
    assert_eq!(list(value).len(), N);
    SVector::from_fn(|row, _| number(&value[row]))
}

pub(crate) fn matrix<const R: usize, const C: usize>(value: &Value) -> SMatrix<f64, R, C> {
    assert_eq!((list(value).len(), list(&value[0]).len()), (R, C));
    SMatrix::from_fn(|row, column| number(&value[row][column]))
}

/// A discrete model under `{prefix}A` and `{prefix}B`.
pub(crate) fn discrete(value: &Value, prefix: &str) -> Discrete<f64> {
    Discrete {
        a: matrix(&value[format!("{prefix}A")]),
        b: matrix(&value[format!("{prefix}B")]),
    }
}

/// Largest difference of two matrices.
pub(crate) fn distance<const R: usize, const C: usize>(
    left: &SMatrix<f64, R, C>,
    right: &SMatrix<f64, R, C>,
) -> f64 {
    (left - right).amax()
}
