//! The output of a control law.

use nalgebra::Vector2;

/// Torques demanded by a control law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand<T> {
    /// Joint torques in N m.
    pub torque_nm: Vector2<T>,
    /// The share of them, in N m, that corrects errors.
    pub feedback_nm: Vector2<T>,
}
