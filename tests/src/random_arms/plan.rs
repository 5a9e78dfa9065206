//! The default plan, performed by the board on an unknown virtual arm.

use armbridge_analysis::plan_runner::plan::InitialSettings;
use armbridge_analysis::plan_runner::{Plan, PlanRunner};
use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_board::bridge::Channels;
use armbridge_client::Host;
use armbridge_link::message::{Limits, Record, Settings, Setup};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::plant::{Plant, PlantConfig};

/// The plan that ships, and how a board works that performs it.
pub fn shipped() -> (Plan, Setup) {
    let scenario = Scenario::load("identify", &Overrides::default()).unwrap();
    (scenario.plan, scenario.settings.setup)
}

/// Records of a board with this set-up. The motors of an arm that is not known yet are not
/// compared with its model.
pub fn perform(plan: &Plan, setup: Setup, config: &PlantConfig, seed: u64) -> Vec<Record> {
    let limits = Limits {
        check_rad_s2: 0,
        ..Limits::default()
    };
    let mut plan = plan.clone();
    plan.begin = InitialSettings::Fixed(Box::new(Settings { setup, limits }));
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
