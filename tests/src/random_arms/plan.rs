//! The default plan, performed by the board on an unknown virtual arm.

use armbridge_analysis::plan_runner::PlanRunner;
use armbridge_analysis::plan_runner::plan::InitialSettings;
use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_board::bridge::Channels;
use armbridge_client::Host;
use armbridge_link::message::{Record, Settings, Setup};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::plant::{Plant, PlantConfig};

/// The set-up of a board that performs the plan that ships, and had this one before.
pub fn shipped(setup: Setup) -> Setup {
    load(setup).settings.setup
}

/// The plan that ships, for a board with this set-up.
fn load(setup: Setup) -> Scenario {
    let board = Settings {
        setup,
        ..Settings::default()
    };
    let overrides = Overrides {
        board: Some(board),
        ..Overrides::default()
    };
    Scenario::load("identify", &overrides).unwrap()
}

/// Records of a board with this set-up that performs the plan that ships, within the limits of the
/// plan.
pub fn perform(setup: Setup, config: &PlantConfig, seed: u64) -> Vec<Record> {
    let scenario = load(setup);
    let settings = Settings {
        setup,
        limits: scenario.settings.limits,
    };
    let mut plan = scenario.plan;
    plan.begin = InitialSettings::Fixed(Box::new(settings));
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = Bench::new(Plant::new(*config, seed));
    let mut cosim = Cosim::new(board, bench, PlanRunner::new(plan));
    while !cosim.host.is_done() {
        cosim.step().unwrap_or_else(|error| match error {
            CosimError::Host(error) => panic!("{error}"),
            CosimError::Board(never) => match never {},
        });
    }
    cosim.host.into_parts().0
}
