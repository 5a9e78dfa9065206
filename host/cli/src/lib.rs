//! Parts of the `armbridge` program behind its command line: configuration, dashboard,
//! Foxglove server, and the tasks of one-line commands.
#![forbid(unsafe_code)]

pub mod config;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod link_thread;
mod open_commands;
pub mod tasks;
pub mod watch;
