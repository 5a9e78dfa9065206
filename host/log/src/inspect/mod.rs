//! Looking at logs: what one holds, and where two differ.

pub mod diff;
pub mod info;
pub mod log;
pub mod settings;

pub use diff::Diff;
pub use info::Info;
pub use log::{Head, Log};
