//! Torque from estimated state, and what the state shall be.
//!
//! [`Lqr`] is the state feedback (9), [`Setpoint`] where it shall hold the arm.
//! [`ComputedTorque`] follows a moving [`Reference`](crate::trajectory::Reference), which a
//! [trajectory](crate::trajectory) gives. A [`Controller`] is either law, chosen at run time,
//! [`IntegralAction`] what either adds against errors that last, and [`DryFriction`] against
//! friction. [`Float`] makes an arm weightless, which a hand leads.

pub mod computed_torque;
mod demand;
pub mod float;
pub mod friction;
mod integral;
mod law;
mod lqr;

pub use computed_torque::{ComputedTorque, Tuning};
pub use demand::Demand;
pub use float::{Float, FloatState};
pub use friction::DryFriction;
pub use integral::IntegralAction;
pub use law::Controller;
pub use lqr::{Lqr, Setpoint, WEIGHT_MAX, Weights};
