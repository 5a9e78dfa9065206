//! The fault campaign with both servo firmwares: `armbridge fault-campaign --seeds 10000`.

use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign;
use armbridge_tests::fault_campaign::campaign;

const SEEDS: u64 = 10_000;

fn print_campaign(servos: Firmware) {
    let (_, report) = campaign(SEEDS, servos);
    println!("{}", fault_campaign::table(&report));
}

#[test]
fn ten_thousand_faults_end_with_motors_off() {
    print_campaign(Firmware::Morpheus);
}

#[test]
fn ten_thousand_faults_with_stock_servos_end_with_motors_off() {
    print_campaign(Firmware::Stock);
}
