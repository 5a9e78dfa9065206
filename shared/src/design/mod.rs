//! Gains from models.
//!
//! [`riccati`] finds the state feedback that is optimal for a discrete model
//! and quadratic weights, [`placement`] the observer gain that gives one joint
//! chosen poles. Both run at set-up, on the board as on the host.

pub mod placement;
pub mod riccati;
