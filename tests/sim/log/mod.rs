//! Logs: what is written is read back, for any messages and after any damage to the file.

mod csv;
mod damage;
mod export;
mod kill;
mod mutated;
mod python;
mod random_messages;
mod raw;
mod round_trip;
mod schema;
mod settings;
mod simulation;

use std::path::PathBuf;

use armbridge_link::message::Settings;
use armbridge_log::run_info::RunFacts;

/// A fresh, empty folder for one test.
fn folder(name: &str) -> PathBuf {
    crate::folder(&format!("log-{name}"))
}

fn facts() -> RunFacts {
    RunFacts::from_settings("test", "simulated: nothing", &Settings::default())
}
