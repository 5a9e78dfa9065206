//! `armbridge` as a user meets it: what it prints, where, and how it ends.
//!
//! A module a command or a subject: `cargo test -p armbridge --test program walk::`.

mod cli;
#[cfg(unix)]
mod doctor;
#[cfg(unix)]
mod emulator;
mod headlines;
mod identification;
mod inspect;
mod interrupted;
#[cfg(target_os = "linux")]
mod json;
mod links;
#[cfg(target_os = "linux")]
mod listeners;
mod live;
mod merge;
mod output;
mod pages;
mod program;
mod readme;
mod refusals;
mod replay;
mod run;
mod scenarios;
mod servo_bus;
mod servos;
mod settings;
mod setup;
#[cfg(unix)]
mod signals;
mod sweeps;
#[cfg(unix)]
mod terminal;
mod transparent;
mod viewers;
mod walk;
mod watch;
mod widths;

use std::path::PathBuf;

/// A fresh, empty folder for one test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
