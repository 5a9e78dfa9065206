//! The library behind the `armbridge` program.
#![forbid(unsafe_code)]

pub mod bench;
pub mod bus;
pub mod config;
pub mod design;
pub mod document;
#[cfg(unix)]
pub mod emulator;
pub mod endpoint;
pub mod errand;
pub mod experiment;
pub mod export;
pub mod facts;
pub mod feed;
pub mod held;
pub mod identify;
pub mod interrupt;
pub mod link;
pub mod links;
pub mod live;
pub mod log;
pub mod look;
pub mod operator;
mod page;
pub mod paper;
pub mod params;
pub mod player;
pub mod plot;
pub mod progress;
#[cfg(unix)]
pub mod pty;
pub mod refusal;
pub mod remote;
pub mod replay;
pub mod run_folder;
pub mod scenario;
pub mod serve;
pub mod servo_table;
pub mod session;
pub mod station;
pub mod summary;
pub mod table;
pub mod torture;
pub mod transparent;
pub mod trial;
pub mod trip;
pub mod wall;
pub mod watch;
