//! The fault campaign with both servo firmwares: `armbridge torture --seeds 10000`.

use std::convert::Infallible;

use armbridge_analysis::monte_carlo::for_seeds;
use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign::{self, Report};

const SEEDS: u64 = 10_000;

fn campaign(servos: Firmware) {
    let seeds: Vec<u64> = (0..SEEDS).collect();
    let run = |seed| Ok::<_, Infallible>(fault_campaign::run(seed, servos));
    let report = Report::of(&for_seeds(&seeds, run, |_| ()).unwrap());
    let table = fault_campaign::table(&report);
    println!("{table}");
    assert!(report.holds(), "{table}");
}

#[test]
fn ten_thousand_faults_end_with_motors_off() {
    campaign(Firmware::Morpheus);
}

#[test]
fn ten_thousand_faults_with_stock_servos_end_with_motors_off() {
    campaign(Firmware::Stock);
}
