//! The guard as a whole.

extern crate std;

mod plant;
mod soft_stop;
