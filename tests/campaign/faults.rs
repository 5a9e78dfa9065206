//! The fault campaign: `armbridge fault-campaign --seeds 20000`.

use armbridge_sim::fault_campaign;
use armbridge_tests::fault_campaign::campaign;

const SEEDS: u64 = 20_000;

#[test]
fn twenty_thousand_faults_end_with_motors_off() {
    let (_, report) = campaign(0..SEEDS);
    println!("{}", fault_campaign::table(&report));
}
