//! Torque from estimated state.
//!
//! [`Lqr`] is the state feedback (9), [`Setpoint`] where it shall hold the arm.

mod lqr;

pub use lqr::{Lqr, Setpoint, Weights};
