//! The guard as a whole.

mod judge;
mod plant;
mod shape;
mod soft_stop;
