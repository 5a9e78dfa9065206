//! Cases of the fault campaign: many of them, and one replayed through the board's code.

use std::convert::Infallible;

use armbridge_analysis::monte_carlo::for_seeds;
use armbridge_log::replay::{Changes, Replayer};
use armbridge_servo::Firmware;
use armbridge_sim::fault_campaign::{self, Case, Kind, Outcome, Report, run_with_events};

/// Runs the cases of these seeds, as `case` makes them.
///
/// # Panics
/// If one of them, of a kind that boards detect, violates a requirement.
pub fn campaign(
    seeds: impl IntoIterator<Item = u64>,
    case: fn(u64) -> Case,
) -> (Vec<Outcome>, Report) {
    let seeds: Vec<u64> = seeds.into_iter().collect();
    let run = |seed| Ok::<_, Infallible>(fault_campaign::run(&case(seed)));
    let outcomes = for_seeds(&seeds, run, |_| ()).unwrap();
    let report = Report::new(&outcomes);
    let holds = report.holds_for_detected_kinds();
    assert!(holds, "{}", fault_campaign::table(&report));
    (outcomes, report)
}

/// Whether the records of a case have all that its board's decisions follow from.
///
/// They have no changes of the memory, no settings of an earlier boot, no end of a board, and
/// none of a disarmed board after a goodbye. Nor have they a stop that repeats itself because an
/// idle servo was not heard; it releases stock servos, whose ticks may then take longer.
pub fn is_in_log(case: &Case) -> bool {
    let is_hard_to_hear = |kind| matches!(kind, Kind::Bytes(..) | Kind::DuplicateId);
    let is_kind_in_log = |kind| {
        !matches!(
            kind,
            Kind::Corrupt
                | Kind::CorruptState
                | Kind::CorruptDrive
                | Kind::CorruptReference
                | Kind::FlashRot
                | Kind::BrownOut
        )
    };
    let is_released = case.servos() == Firmware::Stock
        && case.injections.iter().any(|it| is_hard_to_hear(it.kind));
    !is_released
        && (case.activity.is_armed() || !case.has(Kind::Goodbye))
        && case.injections.iter().all(|it| is_kind_in_log(it.kind))
}

/// Replays the case of this seed; how many ticks were compared, of how many. None, if they
/// are not [in the log](is_in_log).
pub fn replay(seed: u64) -> (u64, u64) {
    let case = Case::new(seed);
    if !is_in_log(&case) {
        return (0, 0);
    }
    let mut player = Replayer::new(Changes::default()).unwrap();
    let _ = run_with_events(&case, |event| {
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
