//! Result of a run in one sentence, by its verdict.

use armbridge_client::ctrl_c;
use armbridge_log::summary::{SETTLED_RAD, SegmentSummary, Summary};

use super::Verdict;

/// The result in one sentence. A free arm, in an experiment or floating, need not balance.
pub fn headline(summary: &Summary, verdict: Verdict, is_free: bool) -> String {
    let failed = |why: &str| format!("The run FAILED: {why}.");
    match verdict {
        Verdict::Interrupted => format!(
            "The run was interrupted by {}; the motors are off.",
            ctrl_c::in_words()
        ),
        Verdict::Failed => match (&summary.faults[..], &summary.ended) {
            ([.., fault], _) => format!(
                "The run FAILED at {:.3} s: fault {}; the motors are off.",
                fault.time_s, fault.fault
            ),
            ([], Some(ended)) => failed(ended),
            ([], None) => failed(match &summary.missed_expectations[..] {
                [] => "the log or a file beside it is not complete",
                [_] => "an expectation of the scenario is missed",
                [_, ..] => "expectations of the scenario are missed",
            }),
        },
        Verdict::Done => match settled(&summary.segments) {
            _ if is_free => "The run is complete, and ended as it should.".into(),
            (0, 0) => "The run is complete.".into(),
            (settled, all) if settled == all => "The arm balances.".into(),
            (settled, all) => format!(
                "The arm stands; both joints come within {:.0} mrad at {settled} of {all} setpoints.",
                SETTLED_RAD * 1e3
            ),
        },
    }
}

/// Setpoints at which both joints settle, and all.
pub fn settled(segments: &[SegmentSummary]) -> (usize, usize) {
    let is_settled = |segment: &&SegmentSummary| {
        let mut joints = segment.joints.iter();
        joints.all(|joint| joint.settling_time_s.is_some())
    };
    (segments.iter().filter(is_settled).count(), segments.len())
}
