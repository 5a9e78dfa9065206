//! `info`, `plot`, `export` and `diff`, as a user meets them, on logs from the bench.

mod bench;
mod figures;
#[cfg(target_os = "linux")]
mod memory;
mod program;
mod robot_description;

use std::path::PathBuf;

/// A fresh, empty folder for one test.
fn folder(name: &str) -> PathBuf {
    crate::folder(&format!("look-{name}"))
}
