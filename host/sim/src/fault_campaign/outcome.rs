//! Outcome of a case.

use serde::Serialize;

use super::case::Case;
use super::kind::Kind;

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Seed of the case.
    pub seed: u64,
    /// Injected kinds.
    pub kinds: Vec<Kind>,
    /// Fault of the board, if there was one.
    pub fault: Option<&'static str>,
    /// Whether that is an expected one.
    pub is_fault_expected: bool,
    /// From the first injection to the fault, in ms.
    pub detected_ms: Option<f64>,
    /// Longest time for which a motor was on in a mode that does not drive it, in ms,
    /// not counting time in which its servo could not be reached.
    pub stop_ms: f64,
    /// Whether the board was idle after the fault was cleared; `None` if it was not cleared.
    pub is_cleared: Option<bool>,
    /// Violated requirements.
    pub failures: Vec<String>,
}

impl Outcome {
    /// Outcome before the start of a case.
    pub(super) fn new(case: &Case) -> Self {
        Self {
            seed: case.seed,
            kinds: case.injections.iter().map(|i| i.kind).collect(),
            fault: None,
            is_fault_expected: true,
            detected_ms: None,
            stop_ms: 0.0,
            is_cleared: None,
            failures: Vec::new(),
        }
    }

    /// Whether one fault was injected, not a pair.
    pub(crate) fn is_single(&self) -> bool {
        self.kinds.len() == 1
    }

    /// Adds a violated requirement, once.
    pub(super) fn fail(&mut self, reason: String) {
        if !self.failures.contains(&reason) {
            self.failures.push(reason);
        }
    }

    /// The outcome with a violated requirement.
    #[must_use]
    pub(super) fn failed(mut self, reason: String) -> Self {
        self.fail(reason);
        self
    }
}
