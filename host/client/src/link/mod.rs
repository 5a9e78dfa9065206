//! The host's end of the control link.

mod client;

pub use client::{Client, LinkStats, Said};
