//! A campaign in numbers, kind by kind.

use std::collections::BTreeMap;

use serde::Serialize;

use super::kind::Kind;
use super::outcome::Outcome;

/// Share of singles that have to be named right.
pub const NAMED_RIGHT: f64 = 0.99;

/// What became of the cases of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The kind, or what the cases have in common.
    pub name: &'static str,
    /// How many cases.
    pub cases: usize,
    /// Of those, how many were called what they are.
    pub named_right: usize,
    /// From injection to fault, in ms: the usual case,
    pub median_detected_ms: Option<f64>,
    /// and the worst.
    pub worst_detected_ms: Option<f64>,
    /// From there to both motors off, in ms, in the worst case.
    pub worst_stop_ms: f64,
    /// How often they were called what.
    pub called: BTreeMap<&'static str, usize>,
}

/// A case that is not as it must be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Of the case: it can be told again.
    pub seed: u64,
    /// What was injected.
    pub kinds: Vec<Kind>,
    /// What is wrong.
    pub why: Vec<String>,
}

/// What became of all cases.
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
    /// What must never happen, and did.
    pub failures: Vec<Failure>,
    /// Singles that were called what they are not.
    pub misnamed: Vec<Failure>,
}

impl Report {
    /// Of these cases.
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

    /// Whether everything is as it must be.
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
