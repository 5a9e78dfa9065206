//! Logs of the bench, recorded as any run is.

use std::path::Path;

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_client::Tap;
use armbridge_client::event::Direction;
use armbridge_link::message::{Settings, Setup};
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_sim::link::{BoardUri, Options};
use armbridge_sim::plant::{Plant, PlantConfig, Push};
use armbridge_sim::{Bench, link};

/// A run to be recorded.
#[derive(Clone, Copy)]
pub(crate) struct Run {
    pub(crate) setup: Setup,
    pub(crate) seed: u64,
    /// Torque in N m that pushes the first joint 1 s after power-up.
    pub(crate) push_nm: Option<f64>,
    /// Frames from the board of which nothing is recorded.
    pub(crate) deaf: [usize; 2],
}

impl Default for Run {
    fn default() -> Self {
        Self {
            setup: Setup::best(),
            seed: 1,
            push_nm: None,
            deaf: [0; 2],
        }
    }
}

/// A recorder that receives nothing for a while.
struct Deaf {
    tap: Box<dyn Tap>,
    words: usize,
    missed: [usize; 2],
}

impl Tap for Deaf {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        if direction == Direction::ToHost && !bytes.is_empty() {
            self.words += 1;
            if (self.missed[0]..self.missed[1]).contains(&self.words) {
                return;
            }
        }
        self.tap.bytes(direction, host_ns, bytes);
    }

    fn disconnected(&mut self, host_ns: u64) {
        self.tap.disconnected(host_ns);
    }
}

/// Stands upright for 2 s and goes to two more setpoints; writes `run.mcap`.
pub(crate) fn record(folder: &Path, run: Run) {
    let settings = Settings {
        setup: run.setup,
        ..Settings::default()
    };
    let mut facts = RunFacts::from_settings("test", "simulated: bench", &settings);
    facts.seed = Some(run.seed);
    let mut plant = PlantConfig::default();
    plant.initial.q = [0.1, -0.1].into();
    let mut bench = Bench::new(Plant::new(plant, run.seed));
    if let Some(torque_nm) = run.push_nm {
        bench.push(Push {
            joint: 0,
            torque_nm,
            start_ns: 1_000_000_000,
            duration_ns: 200_000_000,
        });
    }
    let recorder = Recorder::create_waiting(&folder.join("run.mcap"), &facts).unwrap();
    let mut options = Options::new(bench);
    options.link.taps.push(Box::new(Deaf {
        tap: recorder.tap(),
        words: 0,
        missed: run.deaf,
    }));
    let runner = PlanRunner::new(Script::demo(run.setup, 2_000_000));
    let (_, result) = link::drive(&BoardUri::Sim, options, runner);
    // A fault ends the run early, which is as it should be.
    assert!(result.is_ok() || run.push_nm.is_some(), "{result:?}");
    let report = recorder.finish().unwrap();
    assert_eq!(report.trouble, None);
}
