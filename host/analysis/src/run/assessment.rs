//! Assessment of a run by its end and its expectations, in a run folder or in a sweep.

use armbridge_log::summary::{Summary, Tally};

use crate::plan_runner::Ending;
use crate::scenario::{ExpectationMonitor, Success};

/// Assessment of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assessment {
    /// The run ended in a way that counts as success.
    pub is_success: bool,
    /// Cause of an end before its time, other than a fault.
    pub ended: Option<String>,
    /// Name of the fault that ended it, where that is no success.
    pub fault: Option<&'static str>,
    /// Expectations that are not met.
    pub missed: Vec<String>,
}

/// Assesses a run that ended with `ending`, or by an error of its link.
pub fn assess(
    ending: Option<Ending>,
    error: Option<String>,
    success: &[Success],
    judge: Option<ExpectationMonitor>,
    tally: &Tally,
    summary: &Summary,
) -> Assessment {
    let is_success = error.is_none()
        && ending.is_some_and(|ending| success.iter().any(|success| success.matches(ending)));
    let fault = match ending {
        Some(Ending::Fault(fault)) if !is_success => Some(fault.name()),
        _ => None,
    };
    let missed = match (ending, judge) {
        (_, Some(judge)) if is_success => judge.misses(tally, summary),
        // The whole time is no early end, and no success if another end is expected.
        (Some(Ending::Time), _) if !is_success && error.is_none() => {
            let names: Vec<&str> = success.iter().map(|success| success.name()).collect();
            vec![format!(
                "the run lasts its whole time and does not end by {}",
                names.join(" or ")
            )]
        }
        _ => Vec::new(),
    };
    let ended = error.or_else(|| match ending {
        // Faults are described in more detail elsewhere.
        Some(Ending::Time | Ending::Fault(_)) | None => None,
        Some(end @ (Ending::Angle { .. } | Ending::Error { .. } | Ending::Interrupted)) => {
            Some(end.in_words())
        }
    });
    Assessment {
        is_success,
        ended,
        fault,
        missed,
    }
}
