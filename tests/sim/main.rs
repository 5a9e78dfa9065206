//! Everything that runs in one process: the board's code, the bench, hosts and logs.
//!
//! A module a subject: `cargo test -p armbridge-tests --test sim torque_off::`.

mod calibration;
mod closed_loop;
mod control;
mod current_control;
mod endurance;
mod experiments;
mod fall;
mod fault_campaign;
mod float;
mod golden;
mod host_sessions;
mod identification;
mod layers;
mod load_friction;
mod log;
mod one_joint;
mod own_control;
mod paper;
mod paper_report;
mod park;
mod plan_runner;
mod plot;
mod random_bytes;
mod reconfiguration;
mod replay;
mod safety_case;
mod schematic;
mod servo_time_steps;
mod servo_tools;
mod settings;
mod summary;
mod summary_torque;
mod supervisor;
mod sweep;
mod temperatures;
mod torque_off;
mod transparent_port;
mod wire;
mod x_series;

use std::path::PathBuf;

/// A fresh, empty folder for one test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
