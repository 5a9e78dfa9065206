//! `info`, `plot`, `export` and `diff`, as a user meets them, on logs from the bench.

mod bench;
mod program;

use std::path::PathBuf;

/// A fresh, empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("look")
        .join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
