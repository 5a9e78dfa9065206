//! Parts of the `armbridge` program behind its command line: configuration, dashboard,
//! Foxglove and JSON servers, the tasks of one-line commands, and the guide to the first motion.
#![forbid(unsafe_code)]
// They panic where the output is gone: `armbridge_client::stdio` does not.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod board_tasks;
pub mod config;
pub mod device_permissions;
pub mod finding;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod json_server;
mod pending_commands;
pub mod setup;
pub mod watch;
