//! Results of a campaign, kind by kind.

use std::collections::BTreeMap;

use serde::Serialize;

use super::kind::Kind;
use super::outcome::Outcome;

/// Share of singles whose fault must be an expected one.
pub const EXPECTED_SHARE_MIN: f64 = 0.99;

/// Results of the cases of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The kind, or the group of cases.
    pub name: &'static str,
    /// Number of cases.
    pub cases: usize,
    /// Those with an expected fault.
    pub as_expected: usize,
    /// From injection to fault, in ms: median,
    pub median_detected_ms: Option<f64>,
    /// and maximum.
    pub worst_detected_ms: Option<f64>,
    /// From there to both motors off, in ms, in the worst case.
    pub worst_stop_ms: f64,
    /// Number of cases by fault.
    pub faults: BTreeMap<&'static str, usize>,
}

/// A case that violates a requirement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Seed of the case, which repeats it.
    pub seed: u64,
    /// Injected kinds.
    pub kinds: Vec<Kind>,
    /// Violated requirements.
    pub why: Vec<String>,
}

/// Results of all cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Singles, kind by kind.
    pub singles: Vec<Row>,
    /// All singles.
    pub all_singles: Row,
    /// All pairs.
    pub all_pairs: Row,
    /// Cases in which the fault was cleared.
    pub cleared: usize,
    /// Cases that violate a requirement.
    pub failures: Vec<Failure>,
    /// Singles with an unexpected fault.
    pub unexpected: Vec<Failure>,
}

impl Report {
    /// Summarises these cases.
    pub fn new(outcomes: &[Outcome]) -> Self {
        let singles = || outcomes.iter().filter(|outcome| outcome.is_single());
        let rows = Kind::ALL.into_iter().map(|kind| {
            let cases = singles().filter(|outcome| outcome.kinds == [kind]);
            Row::new(kind.name(), cases)
        });
        let failed = outcomes
            .iter()
            .filter(|outcome| !outcome.failures.is_empty());
        let unexpected = singles().filter(|outcome| !outcome.is_fault_expected);
        Self {
            singles: rows.filter(|row| row.cases > 0).collect(),
            all_singles: Row::new("singles", singles()),
            all_pairs: Row::new("pairs", outcomes.iter().filter(|o| !o.is_single())),
            cleared: outcomes
                .iter()
                .filter(|o| o.is_cleared == Some(true))
                .count(),
            failures: failed
                .map(|outcome| Failure::new(outcome, outcome.failures.clone()))
                .collect(),
            unexpected: unexpected
                .map(|outcome| {
                    let fault = outcome.fault.unwrap_or("none");
                    Failure::new(outcome, vec![format!("fault {fault}")])
                })
                .collect(),
        }
    }

    /// Whether all requirements are met.
    pub fn holds(&self) -> bool {
        let Row {
            cases, as_expected, ..
        } = self.all_singles;
        self.failures.is_empty() && as_expected as f64 >= EXPECTED_SHARE_MIN * cases as f64
    }
}

impl Failure {
    fn new(outcome: &Outcome, why: Vec<String>) -> Self {
        Self {
            seed: outcome.seed,
            kinds: outcome.kinds.clone(),
            why,
        }
    }
}

impl Row {
    fn new<'a>(name: &'static str, outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let mut row = Self {
            name,
            cases: 0,
            as_expected: 0,
            median_detected_ms: None,
            worst_detected_ms: None,
            worst_stop_ms: 0.0,
            faults: BTreeMap::new(),
        };
        let mut detected_ms = Vec::new();
        for outcome in outcomes {
            row.cases += 1;
            row.as_expected += usize::from(outcome.is_fault_expected);
            row.worst_stop_ms = row.worst_stop_ms.max(outcome.stop_ms);
            *row.faults
                .entry(outcome.fault.unwrap_or("none"))
                .or_default() += 1;
            detected_ms.extend(outcome.detected_ms);
        }
        detected_ms.sort_by(f64::total_cmp);
        row.median_detected_ms = detected_ms.get(detected_ms.len() / 2).copied();
        row.worst_detected_ms = detected_ms.last().copied();
        row
    }
}
