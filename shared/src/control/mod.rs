//! Torque from estimated state, and what the state shall be.
//!
//! [`Lqr`] is the state feedback (9), [`Setpoint`] where it shall hold the arm.
//! [`ComputedTorque`] follows a moving [`Reference`], and [`trajectory`] is where
//! that comes from. A [`Controller`] is either law, chosen at run time, and
//! [`DryFriction`] is what either adds against friction.

pub mod computed_torque;
mod controller;
mod demand;
mod friction;
mod lqr;
mod reference;
pub mod trajectory;

pub use computed_torque::{ComputedTorque, Tuning};
pub use controller::Controller;
pub use demand::Demand;
pub use friction::DryFriction;
pub use lqr::{Lqr, Setpoint, Weights};
pub use reference::Reference;
pub use trajectory::{Bounds, Shape, Trajectory};
