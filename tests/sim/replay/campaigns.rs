//! Faults and free hosts: the same again. The campaign has thousands of each.

use armbridge_tests::{fault_campaign, random_host};

#[test]
fn every_kind_of_fault_is_the_same_again() {
    // 34 kinds as singles: even seeds.
    let ticks = (0..34).map(|kind| fault_campaign::replay(2 * kind));
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
