//! Faults and free hosts: the same again. The campaign has thousands of each.

use armbridge_sim::fault_campaign::{Case, Kind};
use armbridge_tests::{fault_campaign, random_host};

#[test]
fn every_kind_of_fault_is_the_same_again() {
    // All kinds as singles, which are even seeds, each in the first activity whose log has all.
    let kinds = Kind::ALL.len() as u64;
    let first = |kind| {
        let mut seeds = (0..12).map(|round| 2 * (kind + kinds * round));
        seeds.find(|seed| fault_campaign::is_in_log(&Case::new(*seed)))
    };
    let seeds: Vec<u64> = (0..kinds).filter_map(first).collect();
    assert_eq!(seeds.len(), 52);
    let ticks = seeds.into_iter().map(fault_campaign::replay);
    let (compared, recorded) = ticks.fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
    assert!(compared * 100 > recorded * 95, "{compared} of {recorded}");
}

#[test]
fn any_run_is_the_same_again() {
    let (mut compared, mut recorded) = (0, 0);
    for seed in 0..60 {
        let (ticks, records) = random_host::run(seed);
        compared += ticks;
        recorded += records as u64;
    }
    assert!(compared * 100 > recorded * 98, "{compared} of {recorded}");
}
