//! Torque from estimated state, and what the state shall be.
//!
//! [`Lqr`] is the state feedback (9), [`Setpoint`] where it shall hold the arm.
//! [`ComputedTorque`] follows a moving [`Reference`], and [`trajectory`] is where
//! that comes from. A [`Controller`] is either law, chosen at run time,
//! [`IntegralAction`] what either adds against errors that last, and [`DryFriction`] against
//! friction.

pub mod computed_torque;
mod controller;
mod demand;
mod friction;
mod integral;
mod lqr;
mod reference;
pub mod trajectory;

pub use computed_torque::{ComputedTorque, Tuning};
pub use controller::Controller;
pub use demand::Demand;
pub use friction::DryFriction;
pub use integral::IntegralAction;
pub use lqr::{Lqr, Setpoint, WEIGHT_MAX, Weights};
pub use reference::Reference;
pub use trajectory::{Bounds, Shape, Trajectory};
