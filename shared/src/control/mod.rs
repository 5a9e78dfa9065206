//! Torque from estimated state, and what the state shall be.
//!
//! [`Lqr`] is the state feedback (9), [`Setpoint`] where it shall hold the arm.
//! [`ComputedTorque`] follows a moving [`Reference`].

mod computed_torque;
mod lqr;
mod reference;

pub use computed_torque::{ComputedTorque, Error as ComputedTorqueError, Tuning};
pub use lqr::{Lqr, Setpoint, Weights};
pub use reference::Reference;
