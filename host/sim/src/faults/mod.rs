//! What can go wrong beside the bus; what can go wrong on it is in
//! [`wire`](super::half_duplex_bus).
//!
//! | module     | what                                                        |
//! |------------|-------------------------------------------------------------|
//! | [`sensor`] | potentiometers and temperatures that lie, servos that change places |
//! | [`host`]   | a host that vanishes, floods, babbles or repeats itself     |
//!
//! Everything is told when it begins, in virtual time, and what is random is
//! seeded: equal inputs give equal outputs.

pub mod host;
pub mod sensor;
