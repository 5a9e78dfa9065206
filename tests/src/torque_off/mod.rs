//! Torque off: the board with everything around it, and scenarios for either world.
//!
//! `rig` is the board with everything around it, `host` and `client` its two users,
//! of which the simulator has the latter;
//! `reports` decodes the board's messages on torque, `cases` runs a table; `sessions`,
//! `silence`, `passthrough` and `x_servos` are scenarios of the bench and the emulator.

pub mod cases;
pub mod host;
pub mod passthrough;
pub mod reports;
pub mod rig;
pub mod sessions;
pub mod silence;
pub mod x_servos;

pub use armbridge_sim::faults::port_client as client;

use client::Method;

/// Every method by which a client drives servos, of either series.
pub const METHODS: [Method; 4] = [Method::Pwm, Method::Speeds, Method::Goals, Method::Duties];
