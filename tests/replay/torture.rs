//! Whatever goes wrong: the same again.

use armbridge_log::replay::{Changes, Player};
use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign::{Case, Kind, overhear};

/// Replays the case of this seed; how many ticks were compared, of how many.
fn replay(seed: u64) -> (u64, u64) {
    // What changes in the board's memory is no input that a log has.
    let case = Case::new(seed, Firmware::Morpheus);
    if case.injections.iter().any(|it| it.kind == Kind::Corrupt) {
        return (0, 0);
    }
    let mut player = Player::new(Changes::default()).unwrap();
    let _ = overhear(seed, Firmware::Morpheus, |event| {
        player.take(&event).unwrap();
    });
    let report = player.finish().unwrap();
    let text = report.text();
    assert_eq!(
        report.differing + report.answers_differing,
        0,
        "seed {seed}: {text}"
    );
    (report.compared, report.records)
}

#[test]
fn every_kind_of_fault_is_the_same_again() {
    // 34 kinds as singles: even seeds.
    let ticks = (0..34).map(|kind| replay(2 * kind));
    let (compared, told) = ticks.fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
    assert!(compared * 100 > told * 95, "{compared} of {told}");
}

#[test]
#[ignore = "minutes: cargo test -p armbridge-tests --test replay -- --ignored a_campaign"]
fn a_campaign_is_the_same_again() {
    let ticks = (0..4_000).map(replay);
    let (compared, told) = ticks.fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
    println!("{compared} of {told} ticks compared");
}
