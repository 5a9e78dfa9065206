//! Cases of the fault campaign: many of them, and one replayed through the board's code.

use std::convert::Infallible;

use armbridge_analysis::monte_carlo::for_seeds;
use armbridge_log::replay::{Changes, Replayer};
use armbridge_shared::servo::Firmware;
use armbridge_sim::fault_campaign::{self, Case, Kind, Outcome, Report, run_with_events};

/// Runs the cases of the seeds below `seeds`.
///
/// # Panics
/// If one of them does not end with motors off.
pub fn campaign(seeds: u64, servos: Firmware) -> (Vec<Outcome>, Report) {
    let seeds: Vec<u64> = (0..seeds).collect();
    let run = |seed| Ok::<_, Infallible>(fault_campaign::run(seed, servos));
    let outcomes = for_seeds(&seeds, run, |_| ()).unwrap();
    let report = Report::new(&outcomes);
    assert!(report.holds(), "{}", fault_campaign::table(&report));
    (outcomes, report)
}

/// Replays the case of this seed; how many ticks were compared, of how many.
pub fn replay(seed: u64) -> (u64, u64) {
    // A log has no changes of the board's memory.
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
