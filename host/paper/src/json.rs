//! JSON output of `armbridge paper --json`: each claim with its verdict and numbers.

use std::path::Path;

use serde::Serialize;

use super::claim::{Claim, Number, Verdict};

/// All claims and the path of the page.
#[derive(Clone, Debug, Serialize)]
pub struct JsonReport<'a> {
    report: &'a Path,
    claims: Vec<JsonClaim<'a>>,
}

#[derive(Clone, Debug, Serialize)]
struct JsonClaim<'a> {
    id: &'a str,
    title: &'a str,
    verdict: Verdict,
    as_printed: Vec<JsonNumber<'a>>,
    our_reading: Vec<JsonNumber<'a>>,
}

#[derive(Clone, Debug, Serialize)]
struct JsonNumber<'a> {
    #[serde(rename = "what")]
    quantity: &'a str,
    unit: &'a str,
    /// `null` if the arm fell.
    found: f64,
    expected: String,
    deviation: Option<f64>,
    holds: bool,
}

impl<'a> JsonReport<'a> {
    /// Report on `claims`, whose page is at `report`.
    pub fn new(report: &'a Path, claims: &'a [Claim]) -> Self {
        let claims = claims
            .iter()
            .map(|claim| JsonClaim {
                id: claim.id,
                title: claim.title,
                verdict: claim.verdict(),
                as_printed: claim.printed.iter().map(json_number).collect(),
                our_reading: claim.reading.iter().map(json_number).collect(),
            })
            .collect();
        Self { report, claims }
    }
}

fn json_number(number: &Number) -> JsonNumber<'_> {
    JsonNumber {
        quantity: &number.quantity,
        unit: number.unit,
        found: number.found,
        expected: number.rule.words(),
        deviation: number.deviation(),
        holds: number.holds(),
    }
}
