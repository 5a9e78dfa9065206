//! Cases of the fault campaign, through the board's code again.

use armbridge_log::replay::{Changes, Replayer};
use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign::{Case, Kind, run_with_events};

/// Replays the case of this seed; how many ticks were compared, of how many.
pub fn replay(seed: u64) -> (u64, u64) {
    // What changes in the board's memory is no input that a log has.
    let case = Case::new(seed, Firmware::Morpheus);
    if case.injections.iter().any(|it| it.kind == Kind::Corrupt) {
        return (0, 0);
    }
    let mut player = Replayer::new(Changes::default()).unwrap();
    let _ = run_with_events(seed, Firmware::Morpheus, |event| {
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
