//! Gains from models.
//!
//! [`riccati`] finds the state feedback that is optimal for a discrete model
//! and quadratic weights, [`placement`] the observer gain that gives one joint
//! chosen poles, and [`stability`] checks whether a closed loop decays. All run at
//! set-up, on the board as on the host.

pub(crate) mod linear_solve;
pub mod placement;
pub mod riccati;
pub mod stability;
