//! What the `armbridge` program does beside its command line: configuration, dashboard,
//! live server, and the tasks of one-line commands.
#![forbid(unsafe_code)]

pub mod config;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod link_thread;
pub mod tasks;
pub mod watch;
