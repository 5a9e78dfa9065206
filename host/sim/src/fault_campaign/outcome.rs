//! Outcome of a case.

use serde::{Deserialize, Serialize};

use super::activity::Activity;
use super::case::Case;
use super::expect::is_guarded;
use super::kind::Kind;
use super::set_up::{Bus, SetUp};

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Outcome {
    /// Seed of the case.
    pub seed: u64,
    /// Injected kinds.
    pub kinds: Vec<Kind>,
    /// Servos and the speed of their bus.
    pub bus: Bus,
    /// Period, estimator and controller.
    pub set_up: SetUp,
    /// Work of the board.
    pub activity: Activity,
    /// Fault of the board, or the refusal that stands for it, if there was one.
    pub fault: Option<String>,
    /// Whether that is an expected one.
    pub is_fault_expected: bool,
    /// From the first injection to the fault, in ms; from arming where that is later and the
    /// injection is there from the beginning.
    pub detected_ms: Option<f64>,
    /// Longest time for which a motor was on in a mode that does not drive it, in ms,
    /// not counting time in which its servo could not be reached.
    pub stop_ms: f64,
    /// Largest speed at which the arm met the table or a stop, in rad/s.
    pub contact_rad_s: f64,
    /// Longest time for which the arm was driven far from its reference, in ms.
    pub far_ms: f64,
    /// Whether the arm was driven against the table or a stop, or far from where it should be.
    pub is_harmed: bool,
    /// Whether the board was idle after the fault was cleared; `None` if it was not cleared.
    pub is_cleared: Option<bool>,
    /// Violated requirements.
    pub failures: Vec<String>,
    /// Whether boards detect all of its faults.
    pub is_guarded: bool,
}

impl Outcome {
    /// Outcome before the start of a case.
    pub(super) fn new(case: &Case) -> Self {
        Self {
            seed: case.seed,
            kinds: case.injections.iter().map(|i| i.kind).collect(),
            bus: case.bus,
            set_up: case.set_up,
            activity: case.activity,
            fault: None,
            is_fault_expected: true,
            detected_ms: None,
            stop_ms: 0.0,
            contact_rad_s: 0.0,
            far_ms: 0.0,
            is_harmed: false,
            is_cleared: None,
            failures: Vec::new(),
            is_guarded: case.injections.iter().all(|it| is_guarded(it, case)),
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
