//! Tests that take minutes: those of `sim` and `program` with many more seeds.
//!
//! A plain `cargo test` leaves it out; `cargo verify --campaign` runs it, as does
//! `cargo test -p armbridge-tests --test campaign`, after `cargo build` for [`paper`].

mod arms;
mod endurance;
mod faults;
mod kill;
mod mutated_logs;
mod paper;
mod replay;
mod streams;
mod x_series;

use std::path::PathBuf;

/// A fresh, empty folder for one test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
