//! `armbridge identify`: logs fitted, plans performed, the paper's experiments,
//! one servo on a pendulum.

mod board;
mod fit;
mod paper;
mod pendulum;
