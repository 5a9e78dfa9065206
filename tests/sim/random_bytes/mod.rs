//! A million random byte streams into every receiver: nothing panics, nothing hangs,
//! nothing is accepted that was not sent.
//!
//! | target                       | streams |
//! |------------------------------|---------|
//! | bus master, [`master`]       | 300 000 |
//! | frame decoder, [`decoder`]   | 500 000 |
//! | board's link end, [`board`]  | 200 000 |
//!
//! [`virtual_servos`] have a million of their own; [`streams`] are 200 000 for each parser,
//! with what must hold as the fuzz targets have it.

mod board;
mod client;
mod commands;
mod decoder;
mod experiments;
mod line;
mod master;
mod servos;
mod session;
mod streams;
mod virtual_servos;
