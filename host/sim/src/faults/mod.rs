//! Faults beside those of the bus, which are in
//! [`wire`](super::half_duplex_bus).
//!
//! | module     | faults                                                      |
//! |------------|-------------------------------------------------------------|
//! | [`sensor`] | wrong angles and temperatures, swapped servos               |
//! | [`host`]   | a host that vanishes, stalls, floods, sends garbage or repeats itself |
//! | [`port_client`] | a client of the transparent port that drives the motors |
//!
//! Each is injected at its start, in virtual time, and random numbers are
//! seeded: equal inputs give equal outputs.

pub mod host;
pub mod port_client;
pub mod sensor;
