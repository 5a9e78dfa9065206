//! How a case went.

use serde::Serialize;

use super::case::Case;
use super::kind::Kind;

/// How a case went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Of the case.
    pub seed: u64,
    /// What was injected.
    pub kinds: Vec<Kind>,
    /// What the board called it, if anything.
    pub fault: Option<&'static str>,
    /// Whether that is right.
    pub is_named_right: bool,
    /// From the first injection to the fault, in ms.
    pub detected_ms: Option<f64>,
    /// The longest that a motor was on in a mode that does not drive it, in ms of
    /// time in which its servo could be reached.
    pub stop_ms: f64,
    /// Whether the board came back when the fault was cleared, where that was tried.
    pub is_cleared: Option<bool>,
    /// What must never happen, and did.
    pub failures: Vec<String>,
}

impl Outcome {
    /// Of a case in which nothing has happened yet.
    pub(super) fn new(case: &Case) -> Self {
        Self {
            seed: case.seed,
            kinds: case.injections.iter().map(|i| i.kind).collect(),
            fault: None,
            is_named_right: true,
            detected_ms: None,
            stop_ms: 0.0,
            is_cleared: None,
            failures: Vec::new(),
        }
    }

    /// Whether one fault was injected, not a pair.
    pub fn is_single(&self) -> bool {
        self.kinds.len() == 1
    }

    /// Notes what must never happen, once.
    pub(super) fn fail(&mut self, why: String) {
        if !self.failures.contains(&why) {
            self.failures.push(why);
        }
    }

    /// The same, with something that must never happen.
    #[must_use]
    pub(super) fn failed(mut self, why: String) -> Self {
        self.fail(why);
        self
    }
}
