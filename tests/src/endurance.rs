//! Runs without a fault, as long as a test has time for.

use armbridge_analysis::plan_runner::Script;
use armbridge_shared::link::message::{Command, Mode, Setup};

use crate::{plant, records, sinusoid};

/// Length of one run, in s: its records fit into 100 MB.
const RUN_S: u64 = 600;

/// Activity of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// It stands upright.
    Standing,
    /// It follows sinusoids of both joints, a minute each.
    Moving,
}

/// Runs the arm for this time, in runs of ten minutes at most, each with a seed of its own and
/// with set-ups in turn. Returns the number of driven ticks.
///
/// # Panics
/// If the board latches a fault.
pub fn drive_for(activity: Activity, duration_s: u64) -> u64 {
    let mut driven = 0;
    for (seed, begin_s) in (0..duration_s).step_by(RUN_S as usize).enumerate() {
        let setup = [Setup::best(), Setup::default()][seed % 2];
        let run_s = RUN_S.min(duration_s - begin_s);
        let script = Script {
            setup,
            commands: commands(activity, run_s),
            duration_us: run_s * 1_000_000,
        };
        for record in records(plant([0.0; 2], true), seed as u64, script) {
            assert!(
                !matches!(record.mode, Mode::Fault(_)),
                "{activity:?}, seed {seed}, tick {}: {:?}",
                record.tick,
                record.mode
            );
            driven += u64::from(record.mode.drive().is_some());
        }
    }
    driven
}

fn commands(activity: Activity, run_s: u64) -> Vec<(u64, Command)> {
    match activity {
        Activity::Standing => vec![(0, Command::Regulate([0.0; 2]))],
        Activity::Moving => (0..run_s)
            .step_by(60)
            .map(|at_s| (at_s * 1_000_000, Command::Follow(sinusoid(59.0))))
            .collect(),
    }
}
