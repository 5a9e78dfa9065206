//! The claims in short, for other programs: the JSON of `armbridge paper --json`.

use std::path::Path;

use serde::Serialize;

use super::claim::{Claim, Number, Verdict};

/// All claims, and where the page is.
#[derive(Clone, Debug, Serialize)]
pub struct Outline<'a> {
    report: &'a Path,
    claims: Vec<ClaimOutline<'a>>,
}

#[derive(Clone, Debug, Serialize)]
struct ClaimOutline<'a> {
    id: &'a str,
    title: &'a str,
    verdict: Verdict,
    as_printed: Vec<NumberOutline<'a>>,
    our_reading: Vec<NumberOutline<'a>>,
}

#[derive(Clone, Debug, Serialize)]
struct NumberOutline<'a> {
    what: &'a str,
    unit: &'a str,
    /// `null` where the arm fell.
    found: f64,
    expected: String,
    deviation: Option<f64>,
    holds: bool,
}

impl<'a> Outline<'a> {
    /// Of these claims, with the page at this path.
    pub fn new(report: &'a Path, claims: &'a [Claim]) -> Self {
        let claims = claims
            .iter()
            .map(|claim| ClaimOutline {
                id: claim.id,
                title: claim.title,
                verdict: claim.verdict(),
                as_printed: claim.printed.iter().map(outline).collect(),
                our_reading: claim.reading.iter().map(outline).collect(),
            })
            .collect();
        Self { report, claims }
    }
}

fn outline(number: &Number) -> NumberOutline<'_> {
    NumberOutline {
        what: &number.what,
        unit: number.unit,
        found: number.found,
        expected: number.rule.words(),
        deviation: number.deviation(),
        holds: number.holds(),
    }
}
