//! The fault campaign: `armbridge fault-campaign --seeds 20000`.

use armbridge_sim::fault_campaign::{self, Case};
use armbridge_tests::fault_campaign::campaign;

const SEEDS: u64 = 20_000;

#[test]
fn twenty_thousand_faults_end_with_motors_off() {
    let (_, report) = campaign(0..SEEDS, Case::new);
    println!("{}", fault_campaign::table(&report));
}

/// The same as `--servos x`.
#[test]
fn twenty_thousand_faults_with_x_servos_end_with_motors_off() {
    let (_, report) = campaign(0..SEEDS, |seed| Case::new(seed).with_x_servos());
    println!("{}", fault_campaign::table(&report));
}
