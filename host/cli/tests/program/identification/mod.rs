//! `armbridge identify`: logs fitted, plans performed, the paper's experiments.

mod board;
mod fit;
mod paper;
