//! Runs without a fault, as long as a test has time for.

use armbridge_analysis::plan_runner::Script;
use armbridge_link::message::{Command, Mode, Setup};
use armbridge_sim::plant::PlantConfig;

use crate::{plant, records, sinusoid};

/// Length of one run, in s: its records fit into 100 MB.
const RUN_S: u64 = 600;
/// Share by which the numbers of drawn arms differ from the default's.
const SPREAD: f64 = 0.3;

/// Activity of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// It stands upright.
    Standing,
    /// It follows sinusoids of both joints, a minute each.
    Moving,
}

/// An arm that works, and what its board knows of it.
#[derive(Clone, Copy, Debug)]
pub struct Arm {
    /// 0: the default arm; others are drawn.
    pub seed: u64,
    /// Noise of the encoders in counts.
    pub noise_counts: f64,
}

impl Arm {
    /// The default arm, with a count of noise.
    pub const DEFAULT: Self = Self {
        seed: 0,
        noise_counts: 1.0,
    };

    fn plant(self) -> PlantConfig {
        let arm = match self.seed {
            0 => plant([0.0; 2], true),
            seed => PlantConfig::drawn(seed, SPREAD),
        };
        PlantConfig {
            noise_lsb_rms: self.noise_counts,
            ..arm
        }
    }

    /// The set-up of its board, which knows the numbers of a drawn arm.
    fn known(self, setup: Setup) -> Setup {
        match self.seed {
            0 => setup,
            _ => self.plant().board_setup(setup),
        }
    }
}

/// Runs an arm for this time, in runs of ten minutes at most, each with a seed of its own and
/// with set-ups in turn. Returns the number of driven ticks.
///
/// # Panics
/// If the board latches a fault.
pub fn drive_for(arm: Arm, activity: Activity, duration_s: u64) -> u64 {
    let mut driven = 0;
    for (seed, begin_s) in (0..duration_s).step_by(RUN_S as usize).enumerate() {
        let setup = [Setup::best(), Setup::default()][(seed + arm.seed as usize) % 2];
        let run_s = RUN_S.min(duration_s - begin_s);
        let script = Script {
            setup: arm.known(setup),
            limits: Script::limits(),
            commands: commands(activity, run_s),
            duration_us: run_s * 1_000_000,
        };
        for record in records(arm.plant(), seed as u64, script) {
            assert!(
                !matches!(record.mode, Mode::Fault(_)),
                "{arm:?}, {activity:?}, seed {seed}, tick {}: {:?}",
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
