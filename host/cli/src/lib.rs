//! Parts of the `armbridge` program behind its command line: configuration, dashboard,
//! Foxglove server, and the tasks of one-line commands.
#![forbid(unsafe_code)]

pub mod board_tasks;
pub mod config;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod link_thread;
mod pending_commands;
pub mod watch;
