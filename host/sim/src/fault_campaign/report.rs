//! Results of a campaign, by kind, activity and set-up.

use std::collections::BTreeMap;

use serde::Serialize;

use super::activity::Activity;
use super::kind::Kind;
use super::outcome::Outcome;

/// Share of singles whose fault must be an expected one.
pub const EXPECTED_SHARE_MIN: f64 = 0.99;

/// Results of a group of cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The group: a kind, an activity, a set-up.
    pub name: String,
    /// Number of cases.
    pub cases: usize,
    /// Those with an expected fault.
    pub as_expected: usize,
    /// Those that violate a requirement.
    pub failed: usize,
    /// From injection to fault, in ms: median,
    pub median_detected_ms: Option<f64>,
    /// and maximum.
    pub worst_detected_ms: Option<f64>,
    /// From there to both motors off, in ms, in the worst case.
    pub worst_stop_ms: f64,
    /// Speed at which the arm met the table or a stop, in rad/s, in the worst case.
    pub worst_contact_rad_s: f64,
    /// Time for which the arm was driven far from its reference, in ms, in the worst case.
    pub worst_far_ms: f64,
    /// Number of cases by fault.
    pub faults: BTreeMap<String, usize>,
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
    /// Singles of the kinds that boards detect.
    pub guarded_singles: Row,
    /// All singles.
    pub all_singles: Row,
    /// All pairs.
    pub all_pairs: Row,
    /// Singles and pairs, by activity.
    pub activities: Vec<Row>,
    /// The same, by servos, and by set-up.
    pub set_ups: Vec<Row>,
    /// Cases in which the fault was cleared.
    pub cleared: usize,
    /// Cases of kinds that boards detect which violate a requirement.
    pub failures: Vec<Failure>,
    /// Singles of these kinds with an unexpected fault.
    pub unexpected: Vec<Failure>,
    /// Cases with a kind that boards do not detect yet which violate a requirement, or singles
    /// with an unexpected fault.
    pub unguarded: Vec<Failure>,
    /// Number of these that violate a requirement.
    pub unguarded_failed: usize,
}

impl Report {
    /// Summarises these cases.
    pub fn new(outcomes: &[Outcome]) -> Self {
        let singles = || outcomes.iter().filter(|outcome| outcome.is_single());
        let rows = Kind::ALL.into_iter().map(|kind| {
            let cases = singles().filter(|outcome| outcome.kinds == [kind]);
            Row::new(kind.name().into(), cases)
        });
        let is_failed = |outcome: &&Outcome| !outcome.failures.is_empty();
        let is_wrong = |outcome: &&Outcome| outcome.is_single() && !outcome.is_fault_expected;
        let guarded = || outcomes.iter().filter(|outcome| outcome.is_guarded);
        let unguarded = || outcomes.iter().filter(|outcome| !outcome.is_guarded);
        let activities = Activity::all().map(|activity| {
            let cases = outcomes.iter().filter(|it| it.activity == activity);
            Row::new(activity.name().into(), cases)
        });
        Self {
            singles: rows.filter(|row| row.cases > 0).collect(),
            guarded_singles: Row::new(
                "detected kinds".into(),
                singles().filter(|outcome| outcome.is_guarded),
            ),
            all_singles: Row::new("singles".into(), singles()),
            all_pairs: Row::new("pairs".into(), outcomes.iter().filter(|o| !o.is_single())),
            activities: activities.filter(|row| row.cases > 0).collect(),
            set_ups: grouped(outcomes, |it| it.bus.to_string())
                .chain(grouped(outcomes, |it| it.set_up.to_string()))
                .collect(),
            cleared: outcomes
                .iter()
                .filter(|o| o.is_cleared == Some(true))
                .count(),
            failures: guarded().filter(is_failed).map(Failure::new).collect(),
            unexpected: guarded().filter(is_wrong).map(Failure::new).collect(),
            unguarded: unguarded()
                .filter(|outcome| is_failed(outcome) || is_wrong(outcome))
                .map(Failure::new)
                .collect(),
            unguarded_failed: unguarded().filter(is_failed).count(),
        }
    }

    /// Whether all requirements are met, also by kinds that boards do not detect yet.
    pub fn holds(&self) -> bool {
        self.holds_for_detected_kinds() && self.unguarded_failed == 0
    }

    /// Whether all requirements on the kinds that boards detect are met.
    pub fn holds_for_detected_kinds(&self) -> bool {
        let Row {
            cases, as_expected, ..
        } = self.guarded_singles;
        self.failures.is_empty() && as_expected as f64 >= EXPECTED_SHARE_MIN * cases as f64
    }
}

/// Rows of the groups of this name, in its order.
fn grouped(outcomes: &[Outcome], name: impl Fn(&Outcome) -> String) -> impl Iterator<Item = Row> {
    let mut groups: BTreeMap<String, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes {
        groups.entry(name(outcome)).or_default().push(outcome);
    }
    let row = |(name, outcomes): (String, Vec<&Outcome>)| Row::new(name, outcomes.into_iter());
    groups.into_iter().map(row)
}

impl Failure {
    fn new(outcome: &Outcome) -> Self {
        let mut why = outcome.failures.clone();
        if !outcome.is_fault_expected {
            let fault = outcome.fault.as_deref().unwrap_or("none");
            why.push(format!("fault {fault}"));
        }
        Self {
            seed: outcome.seed,
            kinds: outcome.kinds.clone(),
            why,
        }
    }
}

impl Row {
    fn new<'a>(name: String, outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let mut row = Self {
            name,
            cases: 0,
            as_expected: 0,
            failed: 0,
            median_detected_ms: None,
            worst_detected_ms: None,
            worst_stop_ms: 0.0,
            worst_contact_rad_s: 0.0,
            worst_far_ms: 0.0,
            faults: BTreeMap::new(),
        };
        let mut detected_ms = Vec::new();
        for outcome in outcomes {
            row.cases += 1;
            row.as_expected += usize::from(outcome.is_fault_expected);
            row.failed += usize::from(!outcome.failures.is_empty());
            row.worst_stop_ms = row.worst_stop_ms.max(outcome.stop_ms);
            row.worst_contact_rad_s = row.worst_contact_rad_s.max(outcome.contact_rad_s);
            row.worst_far_ms = row.worst_far_ms.max(outcome.far_ms);
            let fault = outcome.fault.as_deref().unwrap_or("none");
            *row.faults.entry(fault.into()).or_default() += 1;
            detected_ms.extend(outcome.detected_ms);
        }
        detected_ms.sort_by(f64::total_cmp);
        row.median_detected_ms = detected_ms.get(detected_ms.len() / 2).copied();
        row.worst_detected_ms = detected_ms.last().copied();
        row
    }
}
