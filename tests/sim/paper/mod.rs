//! The mathematics against an independent computation of the paper's numbers.
//!
//! `tests/data/paper-reference.json` holds values found with other tools
//! (symbolic Lagrangian, 50-digit Riccati, Runge-Kutta at 1e-4 s).
//!
//! | module         | what is compared                                          |
//! |----------------|-----------------------------------------------------------|
//! | `model`        | M, G, Co, accelerations, energy, equation (7), ZOH        |
//! | `design`       | K of (10) and its variants, L of (12) and what it really is |
//! | `estimate`     | equation (11), missing samples, f32 against f64           |
//! | `actuator`     | equation (5)                                              |
//! | `trajectories` | eight runs of 45 ms                                       |
//! | `plant`        | the virtual arm's own promises                            |
//! | `falls_and_pushes` | the two experiments that section 3 identifies joint 1 by |
//! | `standing`     | the whole loop in f32 on the virtual arm, without the bus |
#![expect(
    clippy::float_cmp,
    reason = "where numbers are compared exactly, exactness is the claim"
)]

mod actuator;
mod design;
mod estimate;
mod falls_and_pushes;
mod model;
mod plant;
pub(crate) mod reference;
mod standing;
mod trajectories;
