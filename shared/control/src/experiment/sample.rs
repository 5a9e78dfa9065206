//! A signal at one time.

use crate::real::Real;

/// Value and derivatives of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T> {
    /// In its unit.
    pub value: T,
    /// Derivative, per s; 0 at an edge.
    pub first: T,
    /// The second derivative, per s^2; 0 at a corner.
    pub second: T,
}

impl<T: Real> Sample<T> {
    /// One that does not change.
    pub(super) fn level(value: T) -> Self {
        Self {
            value,
            first: T::zero(),
            second: T::zero(),
        }
    }
}
