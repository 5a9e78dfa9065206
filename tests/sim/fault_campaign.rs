//! The fault campaign, small: every kind of fault once, and as many pairs.
//!
//! `armbridge fault-campaign --seeds 10000` is the same with more.

use armbridge_sim::fault_campaign;
use armbridge_sim::fault_campaign::{Case, Kind};
use armbridge_tests::fault_campaign::campaign;

/// Every kind in one activity, and as many pairs.
const SEEDS: u64 = 2 * Kind::ALL.len() as u64;

#[test]
fn whatever_goes_wrong_is_named_and_ends_with_motors_off() {
    let (outcomes, report) = campaign(0..SEEDS);
    let table = fault_campaign::table(&report);
    assert_eq!(report.singles.len(), Kind::ALL.len());
    assert!(report.singles.iter().all(|row| row.cases == 1), "{table}");
    assert!(report.activities.len() == 12, "{table}");
    // It is a campaign: much has gone wrong, and the board has come back from it.
    let faults = outcomes.iter().filter(|outcome| outcome.fault.is_some());
    let (faults, cleared) = (faults.count() as u64, report.cleared as u64);
    assert!(faults > SEEDS / 4 && cleared > SEEDS / 8, "{table}");
    assert!(
        table
            .lines()
            .take(report.singles.len())
            .all(|line| line.len() <= 120),
        "{table}"
    );
}

#[test]
fn a_seed_is_the_same_case_whenever_it_is_run() {
    // One of each kind of randomness: bytes, a second master, sensors, host, client, plant.
    let kinds = [
        "lost-to-servos",
        "second-master",
        "encoder-noise",
        "host-flood",
        "client-baud",
    ];
    for name in kinds {
        let kind: Kind = name.parse().unwrap();
        let seed = 2 * Kind::ALL.iter().position(|it| *it == kind).unwrap() as u64;
        let (outcome, story) = fault_campaign::run_with_trace(seed);
        assert_eq!(
            (outcome.clone(), story.clone()),
            fault_campaign::run_with_trace(seed)
        );
        assert_eq!(outcome, fault_campaign::run(seed));
        for injection in Case::new(seed).injections {
            let name = injection.kind.name();
            assert!(story.matches(name).count() >= 2, "{name}: {story}");
        }
    }
}
