//! A million random byte streams into whatever listens: nothing panics,
//! nothing hangs, nothing is believed that was not said.
//!
//! | target                       | streams |
//! |------------------------------|---------|
//! | bus master, [`master`]       | 300 000 |
//! | frame decoder, [`decoder`]   | 500 000 |
//! | board's link end, [`board`]  | 200 000 |
//!
//! The virtual servos have a million of their own in `fuzz_servo`.

mod board;
mod client;
mod commands;
mod decoder;
mod experiments;
mod frames;
mod line;
mod master;
mod servos;
mod session;
