//! Signals by which an arm is driven so that its model can be identified.
//!
//! A [`Signal`] is plain data, and a function of the time since the experiment began
//! and of its duration: nothing is accumulated from tick to tick, so the same tick
//! gives the same bits wherever it is computed. [`Signal::at`] is for the tick;
//! [`Signal::flaw`] checks whether the numbers make a signal at all, and
//! [`Signal::bounds`] has its extremes, without running it.
//!
//! | signal                  | what it is for                                      |
//! |-------------------------|-----------------------------------------------------|
//! | [`Signal::Constant`]    | the paper's constant-input test; free fall beside   |
//! | [`Signal::Triangle`]    | slow ramps: dry friction and gravity                |
//! | [`Signal::Staircase`]   | dead zone and hysteresis                            |
//! | [`Signal::Steps`]       | stiction; speed versus PWM without gravity          |
//! | [`Signal::Sinusoid`]    | friction at low frequency, inertia at high          |
//! | [`Signal::Chirp`]       | dynamics, one frequency after the other             |
//! | [`Signal::Multisine`]   | dynamics, chosen frequencies at the same time       |
//! | [`Signal::Prbs`]        | dynamics, all frequencies, two levels               |
//!
//! The unit of the value is that of the quantity that the signal drives: N m, PWM counts or
//! rad.
//!
//! # Time
//!
//! In s since the beginning, at most [`DURATION_MAX_S`]. Edges are put on the grid of
//! the ticks: a tick up to 0.1 ms before an edge is taken to be on it, so that the
//! rounding of `f32`, 0.06 ms at the longest, never costs a tick.

mod bounds;
mod pulse;
mod sample;
mod signal;
#[cfg(test)]
mod tests;
mod wave;

pub use crate::trajectory::{DURATION_MAX_S, FREQUENCY_MAX_HZ};
pub use bounds::{Bounds, Flaw, LINES_MAX, TIME_MIN_S};
pub use sample::Sample;
pub use signal::Signal;
