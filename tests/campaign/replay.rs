//! Thousands of faults and of hosts without any plan: the same again.

use std::convert::Infallible;

use armbridge_analysis::monte_carlo::for_seeds;
use armbridge_tests::{fault_campaign, random_host};

#[test]
fn four_thousand_faults_are_the_same_again() {
    let seeds: Vec<u64> = (0..4_000).collect();
    let replay = |seed| Ok::<_, Infallible>(fault_campaign::replay(seed));
    let ticks = for_seeds(&seeds, replay, |_| ()).unwrap();
    let (compared, recorded) = ticks
        .into_iter()
        .fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
    println!("{compared} of {recorded} ticks compared");
    assert!(compared * 100 > recorded * 95, "{compared} of {recorded}");
}

#[test]
fn three_thousand_free_hosts_are_the_same_again() {
    let seeds: Vec<u64> = (1_000..4_000).collect();
    let run = |seed| Ok::<_, Infallible>(random_host::run(seed));
    let ticks = for_seeds(&seeds, run, |_| ()).unwrap();
    let (compared, recorded) = ticks
        .into_iter()
        .fold((0, 0), |(a, b), (c, d)| (a + c, b + d as u64));
    assert!(compared * 100 > recorded * 98, "{compared} of {recorded}");
}
