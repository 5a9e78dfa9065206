//! The library behind the `armbridge` program.
#![forbid(unsafe_code)]

pub mod bench;
pub mod bus;
#[cfg(unix)]
pub mod emulator;
pub mod endpoint;
pub mod facts;
pub mod link;
pub mod log;
pub mod operator;
pub mod paper;
pub mod plot;
pub mod progress;
#[cfg(unix)]
pub mod pty;
pub mod refusal;
pub mod remote;
pub mod run_folder;
pub mod serve;
pub mod summary;
pub mod torture;
pub mod transparent;
pub mod trial;
pub mod wall;
