//! Faults beside those of the bus, which are in
//! [`wire`](super::half_duplex_bus).
//!
//! | module     | faults                                                      |
//! |------------|-------------------------------------------------------------|
//! | [`sensor`] | wrong angles and temperatures, swapped servos               |
//! | [`host`]   | a host that vanishes, floods, sends garbage or repeats itself |
//!
//! Each is injected at its start, in virtual time, and random numbers are
//! seeded: equal inputs give equal outputs.

pub mod host;
pub mod sensor;
