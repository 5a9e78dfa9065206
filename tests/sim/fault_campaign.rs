//! The fault campaign, small: every kind of fault once in every scenario, and as
//! many pairs.
//!
//! `armbridge fault-campaign --seeds 10000` is the same with more.

use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign;
use armbridge_sim::fault_campaign::{Case, Kind};
use armbridge_tests::fault_campaign::campaign;

/// 34 kinds in six scenarios, and as many pairs.
const SEEDS: u64 = 2 * 34 * 6;

#[test]
fn whatever_goes_wrong_is_named_and_ends_with_motors_off() {
    short_campaign(Firmware::Morpheus);
}

#[test]
fn whatever_goes_wrong_with_stock_servos_is_named_and_ends_with_motors_off() {
    short_campaign(Firmware::Stock);
}

/// Both servos are cut off inside packets. Where that of one ends, the error that it
/// answers meets a READ, and it takes the next 255 bytes for another packet.
#[test]
fn a_servo_that_is_cut_off_twice_is_off_in_time() {
    let outcome = fault_campaign::run(2_524, Firmware::Stock);
    assert_eq!(outcome.failures, Vec::<String>::new());
}

/// The reading of the torque enable that would show the reset is itself lost: it is asked
/// again at once.
#[test]
fn a_reset_whose_reading_is_lost_is_noticed_within_100_ms() {
    for seed in [912, 7_848] {
        let detected_ms = fault_campaign::run(seed, Firmware::Stock).detected_ms;
        assert!(
            detected_ms.is_some_and(|ms| ms < 100.0),
            "seed {seed}: {detected_ms:?} ms"
        );
    }
}

fn short_campaign(servos: Firmware) {
    let (outcomes, report) = campaign(SEEDS, servos);
    let table = fault_campaign::table(&report);
    assert_eq!(report.singles.len(), Kind::ALL.len());
    assert!(report.singles.iter().all(|row| row.cases == 6), "{table}");
    // It is a campaign: much has gone wrong, and the board has come back from it.
    let faults = outcomes.iter().filter(|outcome| outcome.fault.is_some());
    let (faults, cleared) = (faults.count() as u64, report.cleared as u64);
    assert!(faults > SEEDS / 3 && cleared > SEEDS / 6, "{table}");
}

#[test]
fn a_seed_is_the_same_case_whenever_it_is_run() {
    let servos = Firmware::Morpheus;
    // One of each kind of randomness: bytes, sensors, host, plant.
    for seed in [1, 6, 38, 44, 60] {
        let (outcome, story) = fault_campaign::run_with_trace(seed, servos);
        assert_eq!(
            (outcome.clone(), story.clone()),
            fault_campaign::run_with_trace(seed, servos)
        );
        assert_eq!(outcome, fault_campaign::run(seed, servos));
        for injection in Case::new(seed, servos).injections {
            let name = injection.kind.name();
            assert!(story.matches(name).count() >= 2, "{name}: {story}");
        }
    }
}
