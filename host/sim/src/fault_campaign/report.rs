//! A campaign in numbers, kind by kind.

use std::collections::BTreeMap;

use serde::Serialize;

use super::kind::Kind;
use super::outcome::Outcome;

/// Share of singles whose fault must be an expected one.
pub const NAMED_RIGHT: f64 = 0.99;

/// Results of the cases of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The kind, or the group of cases.
    pub name: &'static str,
    /// Number of cases.
    pub cases: usize,
    /// Those with an expected fault.
    pub named_right: usize,
    /// From injection to fault, in ms: median,
    pub median_detected_ms: Option<f64>,
    /// and maximum.
    pub worst_detected_ms: Option<f64>,
    /// From there to both motors off, in ms, in the worst case.
    pub worst_stop_ms: f64,
    /// Number of cases by fault.
    pub called: BTreeMap<&'static str, usize>,
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
    pub misnamed: Vec<Failure>,
}

impl Report {
    /// Report on these cases.
    pub fn of(outcomes: &[Outcome]) -> Self {
        let singles = || outcomes.iter().filter(|outcome| outcome.is_single());
        let rows = Kind::ALL.into_iter().map(|kind| {
            let of_kind = singles().filter(|outcome| outcome.kinds == [kind]);
            Row::of(kind.name(), of_kind)
        });
        let failed = outcomes
            .iter()
            .filter(|outcome| !outcome.failures.is_empty());
        let misnamed = singles().filter(|outcome| !outcome.is_named_right);
        Self {
            singles: rows.filter(|row| row.cases > 0).collect(),
            all_singles: Row::of("singles", singles()),
            all_pairs: Row::of("pairs", outcomes.iter().filter(|o| !o.is_single())),
            cleared: outcomes
                .iter()
                .filter(|o| o.is_cleared == Some(true))
                .count(),
            failures: failed
                .map(|outcome| Failure::of(outcome, outcome.failures.clone()))
                .collect(),
            misnamed: misnamed
                .map(|outcome| {
                    let called = outcome.fault.unwrap_or("nothing");
                    Failure::of(outcome, vec![format!("called {called}")])
                })
                .collect(),
        }
    }

    /// Whether all requirements are met.
    pub fn holds(&self) -> bool {
        let Row {
            cases, named_right, ..
        } = self.all_singles;
        self.failures.is_empty() && named_right as f64 >= NAMED_RIGHT * cases as f64
    }
}

impl Failure {
    fn of(outcome: &Outcome, why: Vec<String>) -> Self {
        Self {
            seed: outcome.seed,
            kinds: outcome.kinds.clone(),
            why,
        }
    }
}

impl Row {
    fn of<'a>(name: &'static str, outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let mut row = Self {
            name,
            cases: 0,
            named_right: 0,
            median_detected_ms: None,
            worst_detected_ms: None,
            worst_stop_ms: 0.0,
            called: BTreeMap::new(),
        };
        let mut detected_ms = Vec::new();
        for outcome in outcomes {
            row.cases += 1;
            row.named_right += usize::from(outcome.is_named_right);
            row.worst_stop_ms = row.worst_stop_ms.max(outcome.stop_ms);
            *row.called
                .entry(outcome.fault.unwrap_or("nothing"))
                .or_default() += 1;
            detected_ms.extend(outcome.detected_ms);
        }
        detected_ms.sort_by(f64::total_cmp);
        row.median_detected_ms = detected_ms.get(detected_ms.len() / 2).copied();
        row.worst_detected_ms = detected_ms.last().copied();
        row
    }
}
