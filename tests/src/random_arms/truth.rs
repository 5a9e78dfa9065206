//! The prior of an arm, and its true parameters.

use armbridge_analysis::identify::Quantity;
use armbridge_control::arm::Parameters;
use armbridge_link::message::Setup;
use armbridge_sim::plant::PlantConfig;

use super::kind::Kind;

/// Prior of an arm: the nominal one, but with the true lengths and weight of link 2, as by ruler
/// and scale, and with encoder zeros to three counts, as by calibration.
pub fn prior_setup(config: &PlantConfig, setup: Setup) -> Setup {
    let mut prior = setup;
    prior.arm = Parameters {
        l1: config.arm.l1 as f32,
        l2: config.arm.l2 as f32,
        m2: config.arm.m2 as f32,
        ..setup.arm
    };
    for (servo, truth) in prior.joints.iter_mut().zip(&config.joints) {
        servo.direction = truth.direction;
        servo.zero_count = truth.zero_count as f32 + 3.0;
    }
    prior
}

/// True value of a parameter.
pub fn truth(kind: Kind, config: &PlantConfig, joint: usize, quantity: Quantity) -> f64 {
    match quantity {
        Quantity::DeadBelow => config.dead_zone_counts[joint][0].into(),
        Quantity::DeadAbove => config.dead_zone_counts[joint][1].into(),
        Quantity::Delay => config.input_delay_ns[joint] as f64 * 1e-9 + kind.bus_s()[joint],
        Quantity::Inertia
        | Quantity::Gravity
        | Quantity::Viscous
        | Quantity::Coulomb
        | Quantity::Gain
        | Quantity::Offset
        | Quantity::Zero => quantity.nominal(&config.board_setup(Setup::default()), joint),
    }
}
