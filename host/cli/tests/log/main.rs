//! Logs: what is written comes back, whatever was said, and whatever happened to the
//! file.

mod damage;
mod raw;
mod round_trip;
mod talk;

use std::path::PathBuf;

use armbridge_log::run_info::RunFacts;
use armbridge_shared::link::message::Settings;

/// A fresh, empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("log")
        .join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn facts() -> RunFacts {
    RunFacts::of("test", "simulated: nothing", &Settings::default())
}
