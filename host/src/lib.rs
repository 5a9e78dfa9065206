//! The library behind the `armbridge` program.
#![forbid(unsafe_code)]

pub mod bench;
