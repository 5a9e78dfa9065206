//! Inspection of logs: contents of one, and differences of two.

pub mod diff;
mod drive_text;
pub mod info;
pub mod log;
pub mod settings;

pub use diff::Diff;
pub use info::Info;
pub use log::{Head, Log};
