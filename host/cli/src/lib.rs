//! What the `armbridge` program does beside its command line: configuration, dashboard,
//! live server, and the tasks of one-line commands.
#![forbid(unsafe_code)]

pub mod config;
pub mod link_thread;
#[cfg(feature = "live")]
pub mod live;
pub mod tasks;
pub mod watch;
