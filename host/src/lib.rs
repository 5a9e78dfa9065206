//! The library behind the `armbridge` program.
#![forbid(unsafe_code)]

pub mod bench;
pub mod link;
pub mod operator;
